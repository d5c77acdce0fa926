#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/t4d/byte_source.h"
#include "t4d/error.h"
#include "t4d/file.h"

/// A file in parts: NAME.t4dm, which names .t4d files that follow one another in time (JSON;
/// manifest.schema.json).
namespace t4d::formats {

/// The share of a body that one part has.
struct BodyOfPart {
  BodySummary summary;
  /// Vertices of the layer with which it begins and with which the part before ends.
  std::uint64_t shared = 0;
};

struct ManifestPart {
  std::string path;             ///< as in the manifest: relative to its folder, or a URL
  std::filesystem::path place;  ///< where it is: a path or a URL
  std::uint64_t bytes = 0;
  std::string sha256;  ///< in hexadecimal digits
  std::string
      footer;  ///< in hexadecimal digits; it stands for every byte of the part (SPEC.md, "Footer")
  std::vector<T4dChunks> chunks;
  std::vector<BodyOfPart> bodies;

  model::TimeSpan time() const;
  std::uint64_t slabs() const;
};

struct Manifest {
  std::string head;  ///< that of one file made of the parts: JSON
  Metadata metadata;
  std::vector<ManifestPart> parts;
  /// Members of the parts' metadata that `head` does not have, a line each; of one that is made.
  std::vector<std::string> losses;

  /// The numbers of all parts together.
  BodySummary summary(std::size_t body) const;
  std::uint64_t bytes() const;
};

/// Whether the name of a file, or a URL, is that of a manifest: its extension is .t4dm.
bool isManifest(const std::filesystem::path& pathOrUrl);

/// Reads a manifest, a path or a URL, and none of its parts. Every number is checked, and that
/// the parts of each body follow one another in time. Paths that are absolute or lead out of the
/// manifest's folder are refused.
Result<Manifest> readManifest(const std::filesystem::path& pathOrUrl);

/// The text that readManifest reads.
std::string manifestText(const Manifest& manifest);

/// How the part at `place` is named in a manifest at `manifest`; fails if it is not in its folder
/// or below, and no URL.
Result<std::string> pathInManifest(const std::filesystem::path& place,
                                   const std::filesystem::path& manifest);

/// Opens a part. Fails if it is missing, or not the one that the manifest describes: by its size
/// and its footer, for which nothing else is read.
Result<std::unique_ptr<ByteSource>> openPart(const ManifestPart& part, const std::string& manifest);

/// Fails if a part on this machine is missing or of another size.
Result<void> checkPartsAreThere(const Manifest& manifest, const std::string& name);

/// An error about a part: what it is to which manifest, and the message.
Error inPart(Error error, const ManifestPart& part, const std::string& manifest);

/// The footer of a file with an index, in hexadecimal digits; fails if there is none.
Result<std::string> footerText(ByteSource& file);

/// The SHA-256 of a file in hexadecimal digits.
Result<std::string> sha256Of(ByteSource& file, const model::Progress& progress = {});

}  // namespace t4d::formats
