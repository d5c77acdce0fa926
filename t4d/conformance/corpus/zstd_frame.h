#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// Zstandard frames (RFC 8878), the same bytes whatever library is there, and some no library
/// makes.
namespace t4d::conformance {

struct FrameOptions {
  bool declareSize = true;
  std::optional<std::uint64_t> declaredSize = {};  ///< where it is not that of the content
  /// 2^windowLog bytes, at least 10; none for a frame in one segment, which has no window.
  std::optional<int> windowLog = {};
  std::optional<std::uint32_t> dictionaryId = {};
  /// Content bytes in a block; a block of one byte repeated takes one byte.
  std::size_t blockBytes = 128U << 10;
};

/// A frame of stored and run-length blocks.
std::string zstdFrame(std::string_view content, const FrameOptions& options = {});

/// A frame as the library makes it, which may depend on its version.
std::string zstdByLibrary(std::string_view content, bool checksum = false);

/// The version of that library: 10504 for 1.5.4.
unsigned zstdLibraryVersion();

/// A frame that decoders skip.
std::string zstdSkippableFrame(std::string_view content);

}  // namespace t4d::conformance
