#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>

/// Helpers for fuzz targets.
namespace t4d::fuzz {

/// Aborts the process unless the condition holds; libFuzzer reports that as a finding.
inline void must(bool holds, const std::string& claim) {
  if (holds) return;
  std::fprintf(stderr, "== broken claim: %s\n", claim.c_str());
  std::abort();
}

/// A regular file in memory, for readers that take a path.
class MemoryFile {
 public:
  MemoryFile();
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void set(std::span<const std::uint8_t> bytes);

 private:
  int descriptor_;
  std::filesystem::path path_;
};

/// Counts the heap bytes allocated since its construction. Only one may exist at a time.
class HeapMeter {
 public:
  HeapMeter();
  std::size_t peak() const;
};

}  // namespace t4d::fuzz
