#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/t4d/file_copy.h"
#include "formats/t4d/join.h"
#include "formats/t4d/manifest.h"

namespace t4d::formats {

/// A file to be joined.
struct JoinedPart {
  std::filesystem::path place;
  /// The description of the file, if it comes from a manifest.
  std::optional<ManifestPart> described = {};
};

/// The files, with the parts of a manifest in its place; these are what it describes.
Result<std::vector<JoinedPart>> joinedParts(const std::vector<std::filesystem::path>& files);

/// Puts files together that follow one another in time.
class Joiner {
 public:
  /// The fraction of the work of a join, without a manifest, that is reading the parts.
  static constexpr double kReading = 0.5;

  /// Reads all parts and checks that each continues the one before. Reads only the index of a part
  /// that a manifest describes.
  Result<void> addAll(const std::vector<JoinedPart>& parts, const model::Progress& progress);
  /// Reads and checks one part as addAll does, for a manifest: it will not be copied.
  Result<void> addToName(const JoinedPart& part, const model::Progress& progress);

  /// HEAD of all of them, with its metadata.
  struct JoinedHead {
    CopyHead head;
    Metadata metadata;
  };
  Result<JoinedHead> head(std::vector<std::string>& losses) const;

  /// The last part, as a manifest describes it; without its place, footer and digest.
  ManifestPart described() const;

  /// Copies the parts into one file.
  Result<JoinReport> write(const std::filesystem::path& into,
                           const model::Progress& progress) const;

 private:
  /// The end that the next part of a body must continue.
  struct End {
    double time = 0;
    std::optional<ChunkHeader> layer;  // of the upper layer of the last slab, its offset 0
  };
  /// The ends that the bodies of a part continue: the layers with which they begin there.
  struct Seams {
    std::vector<std::uint64_t> lowers;    // where they are, 0 for bodies that begin
    std::vector<std::uint64_t> vertices;  // how many they have
  };

  Result<void> add(const JoinedPart& part, const model::Progress& progress);
  Result<void> take(Result<CopiedFile> part);
  Metadata metadata(std::vector<std::string>& losses) const;
  std::optional<ChunkHeader> headerAt(const CopiedFile& part, std::uint64_t offset) const;
  Error unfit(const CopiedFile& part, const std::string& message) const;
  Result<void> checkMetadata(const CopiedFile& part) const;
  /// `record` is the first of its body in `part`.
  Result<void> checkSeam(const CopiedFile& part, const IndexRecord& record, Seams& seams) const;
  /// `shared`: vertices of the seam, which are in the part before, too.
  void addSummary(std::size_t body, const BodySummary& added, std::uint64_t shared);

  std::vector<CopiedFile> parts_;
  std::vector<Seams> seams_;  // of the parts
  CopiedChunks chunks_;       // of the parts that are copied, or of the last one
  std::vector<BodySummary> summaries_;
  std::vector<End> ends_;  // of the bodies
};

}  // namespace t4d::formats
