#pragma once

#include <memory>
#include <span>
#include <vector>

#include "formats/t4d/byte_source.h"
#include "platform/open_file.h"

namespace t4d::formats {

/// The bytes of a file that can be read only once, from the front, as they come through a pipe.
/// Each read continues where the last one ended, or repeats one that has not been forgotten. plan()
/// waits for the first byte that is planned, so that size() is right at the end of the file.
class PipeSource : public ByteSource {
 public:
  /// Opens a pipe or any other file; `-` is the standard input.
  static Result<std::unique_ptr<PipeSource>> open(const std::filesystem::path& path);

  PipeSource(const PipeSource&) = delete;
  PipeSource& operator=(const PipeSource&) = delete;
  ~PipeSource() override;

  const std::string& name() const override { return file_.name(); }
  std::uint64_t size() const override;
  bool sizeIsCertain() const override { return false; }
  void plan(std::span<const ByteRange> ranges) override;
  Result<void> read(std::uint64_t offset, std::span<std::byte> into) override;
  /// The number of bytes that were asked for.
  std::uint64_t bytesRead() const override;

  /// Frees the memory of the bytes before size() but those of `ranges`, which are in order.
  void forgetAllBut(std::span<const ByteRange> ranges);

 private:
  struct Kept;
  explicit PipeSource(platform::OpenFile file);
  Result<void> fill();

  platform::OpenFile file_;
  std::unique_ptr<Kept> kept_;
};

}  // namespace t4d::formats
