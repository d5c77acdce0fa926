#pragma once

#include <filesystem>

struct stat;

/// A run must not replace the files that it reads, under whatever name: a part of a manifest, the
/// samples beside a header, an image in a folder.
namespace t4d::platform {

/// The run of a verb. While an object exists, the files that this process opens for reading are
/// noted, by device and inode, and PartFile writes to none of them. Without one nothing is noted,
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
void noteInput(const struct stat& file);

/// Whether the file was noted.
bool isInput(const struct stat& file);

}  // namespace t4d::platform
