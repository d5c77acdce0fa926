#include "tools/verbs/info.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/file.h"
#include "tools/verbs/json_text.h"

namespace t4d::verbs {
namespace {

using nlohmann::ordered_json;

/// The report on a reader, or on a stream that has ended.
template <class File>
InfoReport infoOf(const File& file) {
  InfoReport report{.name = file.name(),
                    .version = file.version(),
                    .indexed = file.indexed(),
                    .bytes = file.fileBytes(),
                    .metadata = file.metadata(),
                    .chunks = file.chunks()};
  for (std::size_t i = 0; i < file.bodyCount(); ++i) report.bodies.push_back(file.summary(i));
  return report;
}

formats::T4dSlab contentsOf(const model::Slab& slab) {
  formats::T4dSlab contents = {{slab.timeBegin, slab.timeEnd}, slab.connectivity->cells.size(), {}};
  for (const model::Point4& vertex : slab.vertices) contents.bounds.add(vertex.head<3>());
  return contents;
}

/// Reads the stream to its end.
Result<InfoReport> infoOfPipe(const std::string& path, const InfoOptions& options) {
  auto stream = formats::T4dStream::open(path, formats::kAnyCells);
  if (!stream) return stream.error();
  std::vector<std::vector<formats::T4dSlab>> slabs(options.slabs ? stream->bodyCount() : 0);
  while (true) {
    const auto item = stream->next();
    if (!item) return item.error();
    if (!*item) break;
    if (options.slabs) slabs[(*item)->body].push_back(contentsOf(*(*item)->slab));
  }
  InfoReport report = infoOf(*stream);
  report.slabs = std::move(slabs);
  return report;
}

Result<InfoReport> infoOfFile(const std::string& path, const InfoOptions& options) {
  const auto reader =
      formats::T4dReader::open(path, formats::T4dOpen::Whole, {}, formats::kAnyCells);
  if (!reader) return reader.error();
  InfoReport report = infoOf(*reader);
  if (!options.slabs) return report;
  report.slabs.resize(reader->bodyCount());
  for (std::size_t body = 0; body < report.slabs.size(); ++body) {
    for (std::size_t i = 0; i < reader->body(body).slabCount(); ++i) {
      const auto slab = reader->slabContents(body, i);
      if (!slab) return slab.error();
      report.slabs[body].push_back(*slab);
    }
  }
  return report;
}

ordered_json cornerJson(const model::Point3& point) { return {point.x(), point.y(), point.z()}; }

ordered_json bodyJson(const std::string& name, const formats::BodySummary& body) {
  return {{"name", name},
          {"slabs", body.slabs},
          {"vertices", body.vertices},
          {"tetrahedra", body.tetrahedra},
          {"time_begin", body.time.begin},
          {"time_end", body.time.end},
          {"bounds_min", cornerJson(body.bounds.min)},
          {"bounds_max", cornerJson(body.bounds.max)}};
}

ordered_json slabJson(const formats::T4dSlab& slab) {
  return {{"begin", slab.time.begin},
          {"end", slab.time.end},
          {"cells", slab.cells},
          {"bounds", {{"min", cornerJson(slab.bounds.min)}, {"max", cornerJson(slab.bounds.max)}}}};
}

}  // namespace

formats::BodySummary InfoReport::total() const {
  formats::BodySummary all = bodies.front();
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const formats::BodySummary& body = bodies[i];
    all.slabs += body.slabs;
    all.vertices += body.vertices;
    all.tetrahedra += body.tetrahedra;
    all.time = {std::min(all.time.begin, body.time.begin), std::max(all.time.end, body.time.end)};
    if (body.vertices > 0) all.bounds.add(body.bounds);
  }
  return all;
}

Result<InfoReport> info(const std::string& path, const InfoOptions& options) {
  return formats::isPipe(path) ? infoOfPipe(path, options) : infoOfFile(path, options);
}

std::string jsonOf(const InfoReport& report) {
  const formats::Metadata& metadata = report.metadata;
  const formats::BodySummary all = report.total();
  ordered_json value = {
      {"format_version", fmt::format("{}.{}", report.version.major, report.version.minor)},
      {"generator", metadata.generator},
      {"backend", metadata.backend},
      {"slabs", all.slabs},
      {"vertices", all.vertices},
      {"tetrahedra", all.tetrahedra},
      {"time_begin", all.time.begin},
      {"time_end", all.time.end},
      {"bounds_min", cornerJson(all.bounds.min)},
      {"bounds_max", cornerJson(all.bounds.max)},
      {"length_unit", metadata.lengthUnit},
      {"time_unit", metadata.timeUnit},
      {"bytes", report.bytes},
      {"up", metadata.up},
      {"space", metadata.space},
      {"attributes", ordered_json::object()},
      {"indexed", report.indexed},
      {"details", ordered_json::parse(metadata.detailsJson)}};
  for (const auto& [name, meaning] : metadata.attributes) {
    value["attributes"][name] = {{"kind", meaning.kind.empty() ? "scalar" : meaning.kind},
                                 {"unit", meaning.unit}};
  }
  for (const formats::T4dChunks& chunks : report.chunks) {
    value["chunks"].push_back(
        {{"type", chunks.type}, {"count", chunks.count}, {"bytes", chunks.bytes}});
  }
  for (std::size_t i = 0; i < report.bodies.size(); ++i) {
    ordered_json body = bodyJson(metadata.bodies[i].name, report.bodies[i]);
    if (!report.slabs.empty()) {
      for (const formats::T4dSlab& slab : report.slabs[i]) {
        body["slab_list"].push_back(slabJson(slab));
      }
    }
    value["bodies"].push_back(std::move(body));
  }
  return jsonText(value);
}

}  // namespace t4d::verbs
