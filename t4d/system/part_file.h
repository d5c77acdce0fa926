#pragma once

#include <filesystem>
#include <span>

#include "t4d/model/error.h"
#include "t4d/system/cleanup.h"

namespace t4d::system {

/// A file that is first written to a hidden file in the same folder, `.NAME.RANDOM.part`, the part,
/// which is renamed when it is complete. So no reader ever sees half a file. A part that has not
/// been renamed is removed by the destructor, or by cleanUp.
class PartFile {
 public:
  /// No file.
  PartFile() = default;
  /// Creates an empty part. Never opens an existing file or a symbolic link. Fails if the target is
  /// a folder, a pipe or a device, which a file must not replace.
  static Result<PartFile> create(const std::filesystem::path& target);

  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&& other) noexcept;
  ~PartFile() { remove(); }

  explicit operator bool() const { return static_cast<bool>(note_); }
  /// The path of the part, to write to.
  const std::filesystem::path& path() const { return path_; }

  /// Renames files of one folder, which are written and closed, to their targets. If one cannot be
  /// renamed, targets that were already replaced get their old contents back (on file systems that
  /// can exchange two files), and all parts stay parts. Waits until files and names are on disk, so
  /// that a crash of the machine leaves no file without content.
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

/// Waits until the names in the folder of a file are on disk.
Result<void> syncNames(const std::filesystem::path& file);

}  // namespace t4d::system
