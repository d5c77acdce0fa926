#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "platform/cleanup.h"
#include "platform/descriptor.h"
#include "t4d/error.h"

namespace t4d::platform {

/// A file that is first written to a hidden file in the same folder, `.NAME.N.part`, the part,
/// which is renamed when it is complete. So no reader ever sees half a file. A part that has not
/// been renamed is removed by the destructor or by cleanUp or, if its process was killed, when the
/// next file with this target is created: a part is locked while it is written.
///
/// A symbolic link is followed. A device or a pipe is written to directly, and so is the standard
/// output, whose name is `-`.
class PartFile {
 public:
  /// A PartFile without a file.
  PartFile() = default;
  /// Creates an empty part; never opens an existing file. Fails if the target is a folder, or an
  /// input of the run (kept_inputs.h).
  static Result<PartFile> create(const std::filesystem::path& target);

  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&& other) noexcept;
  ~PartFile() { remove(); }

  /// Appends; errors name the target and the system's reason (a full disk, say).
  Result<void> write(std::string_view bytes);
  /// Replaces bytes that were written before. Fails if the target is a pipe.
  Result<void> rewrite(std::uint64_t offset, std::string_view bytes);

  /// Ends the writing, and waits until the bytes are on disk. For those who make more parts than a
  /// process can have open: this one is no longer locked.
  Result<void> close();

  /// Renames files of one folder to their targets, when all of them are on disk, and waits until
  /// the names are on disk, too, so that a crash of the machine leaves no file without content.
  /// Fails before the first is renamed if a target has become a folder or an input of the run.
  static Result<void> putInPlace(std::span<PartFile> parts);

  void remove() noexcept;

 private:
  bool isDirect() const { return part_.empty(); }
  Result<void> createPart();
  Result<void> checkTarget() const;

  std::filesystem::path target_;
  std::filesystem::path part_;  // none if the target is written to directly
  Descriptor descriptor_;
  Cleanup note_;
};

}  // namespace t4d::platform
