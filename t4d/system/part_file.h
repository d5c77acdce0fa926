#pragma once

#include <filesystem>
#include <span>

#include "t4d/model/error.h"
#include "t4d/system/cleanup.h"

namespace t4d::system {

/// A file that is written under another name: first to a hidden file in the same folder,
/// `.NAME.RANDOM.part`, which is renamed when it is complete. No reader ever sees half a file. A
/// part that has not been renamed is removed by its destructor, or by cleanUp.
class PartFile {
 public:
  /// No file.
  PartFile() = default;
  /// Creates an empty file. Never opens one that exists, or a symbolic link. Fails if the target is
  /// a folder, a pipe or a device: a file must not take its place.
  static Result<PartFile> create(const std::filesystem::path& target);

  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&& other) noexcept;
  ~PartFile() { remove(); }

  explicit operator bool() const { return static_cast<bool>(note_); }
  /// Where to write.
  const std::filesystem::path& path() const { return path_; }

  /// Renames files of one folder, which are written and closed, to their targets. If one cannot be
  /// renamed, targets that were already replaced get their old contents back (on file systems that
  /// can exchange two files), and all parts stay parts. Waits until files and names are on the
  /// disk, so that a crash of the machine leaves no name without content.
  static Result<void> putInPlace(std::span<PartFile> parts);

  void remove() noexcept;

 private:
  enum class State : char { Part, Placed, Exchanged };

  Result<void> sync() const;
  Result<void> place(bool keepOld);
  void undo() noexcept;

  std::filesystem::path target_;
  std::filesystem::path path_;
  Cleanup note_;
  State state_ = State::Part;
};

}  // namespace t4d::system
