#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// Zstandard frames (RFC 8878) with the same bytes for any version of the library, including some
/// that no library produces.
namespace t4d::conformance {

struct FrameOptions {
  bool declareSize = true;
  std::optional<std::uint64_t> declaredSize = {};  ///< if different from the size of the content
  /// Window of 2^windowLog bytes, at least 10; empty for a single-segment frame, which has no
  /// window.
  std::optional<int> windowLog = {};
  std::optional<std::uint32_t> dictionaryId = {};
  /// Content bytes per block; a block of one repeated byte takes one byte.
  std::size_t blockBytes = 128U << 10;
};

/// A frame of raw and run-length blocks.
std::string zstdFrame(std::string_view content, const FrameOptions& options = {});

/// A frame made by the library; its bytes may depend on the version.
std::string zstdByLibrary(std::string_view content, bool checksum = false);

/// The version of the library: 10504 for 1.5.4.
unsigned zstdLibraryVersion();

/// A skippable frame, which decoders ignore.
std::string zstdSkippableFrame(std::string_view content);

}  // namespace t4d::conformance
