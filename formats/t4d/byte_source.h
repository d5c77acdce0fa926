#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "t4d/error.h"

namespace t4d::formats {

/// Consecutive bytes of a file.
struct ByteRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;  ///< of the byte after the last
};

/// The bytes of a .t4d file, wherever they are, read at any offset. Safe from several threads at
/// once.
class ByteSource {
 public:
  virtual ~ByteSource() = default;

  /// The name for messages.
  virtual const std::string& name() const = 0;
  /// The size in bytes; kUnknownSize for a pipe until its end has come.
  virtual std::uint64_t size() const = 0;
  static constexpr std::uint64_t kUnknownSize = std::uint64_t{1} << 52;
  /// Fills `into` with the bytes from `offset` on, which are within size(). Errors name the file.
  virtual Result<void> read(std::uint64_t offset, std::span<std::byte> into) = 0;

  /// Whether the bytes exist that size() promises.
  virtual bool sizeIsCertain() const { return true; }
  /// Whether each request costs time, so that it is worth while to make few.
  virtual bool remote() const { return false; }
  /// Says what is about to be read, in any order, so that a remote source can fetch it with few
  /// requests. Replaces what was said before. Nothing is fetched until it is read.
  virtual void plan(std::span<const ByteRange> /*ranges*/) {}

  /// Bytes read, or received, so far.
  virtual std::uint64_t bytesRead() const = 0;
  /// Requests made so far; 0 for a local file.
  virtual std::uint64_t requests() const { return 0; }
};

/// Opens a regular file.
Result<std::unique_ptr<ByteSource>> openFileSource(const std::filesystem::path& path);

/// Opens a file on a web server.
using UrlOpener = Result<std::unique_ptr<ByteSource>> (*)(const std::string& url);

/// Sets how openByteSource opens URLs; without it they are refused. Call it before anything is
/// opened.
void setUrlOpener(UrlOpener opener);

/// Opens a regular file, or a file on a web server by its URL: http:// or https://. Other URLs are
/// refused.
Result<std::unique_ptr<ByteSource>> openByteSource(const std::filesystem::path& pathOrUrl);

}  // namespace t4d::formats
