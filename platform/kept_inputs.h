#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>

/// A run must not replace the files that it reads, under whatever name: a part of a manifest, the
/// samples beside a header, an image in a folder.
namespace t4d::platform {

/// What a file is to the system, under all of its names.
struct FileIdentity {
  std::uint64_t device = 0;
  std::uint64_t number = 0;  ///< on this device
  auto operator<=>(const FileIdentity&) const = default;
};

/// That of a file, with links followed; none if there is no such file.
std::optional<FileIdentity> identityOf(const std::filesystem::path& path);

/// The run of a verb. While an object exists, the files that this process opens for reading are
/// noted, by their identities, and PartFile writes to none of them. Without one nothing is noted,
/// so that a program that lives long can write a file that it has read.
class KeptInputs {
 public:
  KeptInputs();
  ~KeptInputs();
  KeptInputs(const KeptInputs&) = delete;
  KeptInputs& operator=(const KeptInputs&) = delete;
};

/// Notes a file that is about to be read. Whatever opens a file for reading calls this, or
/// sizeOfRegularFile, which does.
void noteInput(const std::filesystem::path& path);
void noteInput(const FileIdentity& file);

/// Whether the file was noted.
bool isInput(const FileIdentity& file);

}  // namespace t4d::platform
