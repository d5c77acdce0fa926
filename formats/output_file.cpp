#include "formats/output_file.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace t4d::formats {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

}  // namespace

OutputFile::OutputFile(platform::PartFile part) : part_(std::move(part)) {
  buffer_.reserve(kBufferBytes);
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& target) {
  auto part = platform::PartFile::create(target);
  if (!part) return part.error();
  return OutputFile(std::move(*part));
}

Result<void> OutputFile::flush() {
  auto written = part_.write(buffer_);
  buffer_.clear();
  return written;
}

Result<void> OutputFile::write(const void* data, std::size_t size) {
  std::string_view bytes(static_cast<const char*>(data), size);
  size_ += size;
  while (!bytes.empty()) {
    const std::size_t now = std::min(bytes.size(), kBufferBytes - buffer_.size());
    buffer_.append(bytes.substr(0, now));
    bytes.remove_prefix(now);
    if (buffer_.size() == kBufferBytes) {
      if (auto done = flush(); !done) return done;
    }
  }
  return {};
}

Result<void> OutputFile::rewrite(std::uint64_t offset, const void* data, std::size_t size) {
  if (auto done = flush(); !done) return done;
  return part_.rewrite(offset, {static_cast<const char*>(data), size});
}

Result<void> OutputFile::finish(std::string_view bytes) {
  return write(bytes.data(), bytes.size()).and_then([&] { return commit(); });
}

Result<void> OutputFile::commitAll(std::span<OutputFile> files) {
  std::vector<platform::PartFile> parts;
  for (OutputFile& file : files) {
    if (auto done = file.flush(); !done) return done;
  }
  for (OutputFile& file : files) parts.push_back(std::move(file.part_));
  return platform::PartFile::putInPlace(parts);
}

Result<void> writeOutputFile(const std::filesystem::path& target, std::string_view bytes) {
  auto file = OutputFile::create(target);
  if (!file) return file.error();
  return file->finish(bytes);
}

}  // namespace t4d::formats
