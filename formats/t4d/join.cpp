#include "formats/t4d/join.h"

#include <string>

#include "formats/t4d/joiner.h"
#include "formats/t4d/within_memory.h"
#include "model/progress.h"

namespace t4d::formats {

namespace {

/// Sets place, footer and digest.
Result<void> seal(ManifestPart& part, const std::filesystem::path& place,
                  const model::Progress& progress) {
  auto file = openByteSource(place);
  if (!file) return file.error();
  auto footer = footerText(**file);
  if (!footer) return footer.error();
  auto digest = sha256Of(**file, progress);
  if (!digest) return digest.error();
  part.path = place.string();
  part.place = place;
  part.bytes = (*file)->size();
  part.sha256 = std::move(*digest);
  part.footer = std::move(*footer);
  return {};
}

/// What a manifest says of the parts, but for their paths in it.
Result<Manifest> describe(const std::vector<JoinedPart>& parts, const model::Progress& progress) {
  constexpr double kReading = 0.7;  // the rest is the digest
  Joiner joiner;
  Manifest manifest;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const model::Progress own = model::eachOf(progress, i, parts.size());
    const JoinedPart& given = parts[i];
    const auto added = withinMemory(given.place.string(), [&] {
      return joiner.addToName(given, model::partOf(own, 0, kReading));
    });
    if (!added) return added.error();
    ManifestPart part = joiner.described();
    if (given.described) {
      part = {given.described->path,   given.place,
              given.described->bytes,  given.described->sha256,
              given.described->footer, given.described->chunks,
              std::move(part.bodies)};
    } else if (auto sealed = seal(part, given.place, model::partOf(own, kReading, 1)); !sealed) {
      return sealed.error();
    }
    manifest.parts.push_back(std::move(part));
  }
  std::vector<std::string> losses;
  auto head = joiner.head(losses);
  if (!head) return head.error();
  manifest.head = std::move(head->head.text);
  manifest.metadata = std::move(head->metadata);
  manifest.losses = std::move(losses);
  return manifest;
}

}  // namespace

Result<JoinReport> joinT4d(const std::vector<std::filesystem::path>& files,
                           const std::filesystem::path& into, const model::Progress& progress) {
  const auto parts = joinedParts(files);
  if (!parts) return parts.error();
  Joiner joiner;
  if (auto read = joiner.addAll(*parts, model::partOf(progress, 0, Joiner::kReading)); !read) {
    return read.error();
  }
  return withinMemory(into.string(), [&] {
    return joiner.write(into, model::partOf(progress, Joiner::kReading, 1));
  });
}

Result<Manifest> describeParts(const std::vector<std::filesystem::path>& files,
                               const model::Progress& progress) {
  const auto parts = joinedParts(files);
  if (!parts) return parts.error();
  return describe(*parts, progress);
}

Result<JoinReport> writeManifest(const std::vector<std::filesystem::path>& files,
                                 const std::filesystem::path& into,
                                 const model::Progress& progress) {
  const auto parts = joinedParts(files);
  if (!parts) return parts.error();
  std::vector<std::string> paths;
  for (const JoinedPart& part : *parts) {
    auto path = pathInManifest(part.place, into);
    if (!path) return path.error();
    paths.push_back(std::move(*path));
  }
  auto manifest = describe(*parts, progress);
  if (!manifest) return manifest.error();
  for (std::size_t i = 0; i < paths.size(); ++i) manifest->parts[i].path = std::move(paths[i]);
  const std::string text = manifestText(*manifest);
  if (auto written = writeOutputFile(into, text); !written) return written.error();
  JoinReport report{{}, text.size(), std::move(manifest->losses), parts->size()};
  for (std::size_t i = 0; i < manifest->metadata.bodies.size(); ++i) {
    report.bodies.push_back(manifest->summary(i));
  }
  return report;
}

}  // namespace t4d::formats
