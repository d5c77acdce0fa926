#include "tools/verbs/info.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/file.h"
#include "tools/verbs/members.h"

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

constexpr const char* kCorner =
    "Smallest (bounds_min, min) or largest (bounds_max, max) x, y, z over all times, in length "
    "units; nulls if there are no vertices.";

void addSummary(Members& members, const formats::BodySummary& body) {
  members("slabs", body.slabs,
          "Number of slabs (parts between two consecutive times), including caps.")
      .atLeast(1);
  members("vertices", body.vertices,
          "Number of vertices; one that several slabs share counts once.");
  members("tetrahedra", body.tetrahedra, "Cells of all slabs.");
  members("time_begin", body.time.begin, "First time, in time units.");
  members("time_end", body.time.end, "Last time, in time units.");
  members("bounds_min", body.bounds.min, kCorner).itemsOrNull();
  members("bounds_max", body.bounds.max, kCorner).itemsOrNull();
}

void describeSlab(Members& members, const formats::T4dSlab& slab) {
  members("begin", slab.time.begin, "First time of the slab.");
  members("end", slab.time.end, "Last time of the slab; for a cap, equal to the first.");
  members("cells", slab.cells, "Tetrahedra of the slab.");
  members("bounds", slab.bounds, "Bounds of all vertices of the slab.",
          [](Members& own, const model::Bounds3& bounds) {
            own("min", bounds.min, kCorner).itemsOrNull();
            own("max", bounds.max, kCorner).itemsOrNull();
          });
}

struct BodyInfo {
  std::string name;
  formats::BodySummary summary;
  std::vector<formats::T4dSlab> slabs;  ///< empty unless they are asked for
};

std::vector<BodyInfo> bodiesOf(const InfoReport& report) {
  std::vector<BodyInfo> bodies;
  for (std::size_t i = 0; i < report.bodies.size(); ++i) {
    bodies.push_back({report.metadata.bodies[i].name, report.bodies[i], {}});
    if (!report.slabs.empty()) bodies.back().slabs = report.slabs[i];
  }
  return bodies;
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

void describe(Members& members, const InfoReport& report) {
  const formats::Metadata& metadata = report.metadata;
  members("format_version", fmt::format("{}.{}", report.version.major, report.version.minor),
          "Version of the .t4d format of the file.")
      .pattern("^[0-9]+\\.[0-9]+$");
  members("generator", metadata.generator,
          "Program and version that wrote the file; empty if unknown.");
  members("backend", metadata.backend,
          "How the mesh was made: mesh4d, voxel4d or another word; empty if unknown.");
  addSummary(members, report.bodies.empty() ? formats::BodySummary() : report.total());
  members("length_unit", metadata.lengthUnit, "Unit of x, y, z: mm, m, in, ...; empty if unknown.");
  members("time_unit", metadata.timeUnit, "Unit of t: s, min, ...; empty if unknown.");
  members("bytes", report.bytes, "Size of the file, in bytes.");
  members("up", metadata.up, "The axis that points up.").oneOf({"y", "z"});
  members("space", metadata.space,
          "Directions of the axes relative to a patient: RAS or LPS; empty if unknown.");
  members(
      "attributes", metadata.attributes, "Kinds and units of attributes, by their names.",
      [](Members& own, const model::AttributeMeaning& meaning) {
        own("kind", meaning.kind.empty() ? "scalar" : meaning.kind,
            "scalar, vector, point, normal, color or label; later versions may add others.");
        own("unit", meaning.unit,
            "A unit such as length/time, where length and time mean the units of the file; empty "
            "for none.");
      });
  members("indexed", report.indexed, "Whether the file has an index of its slabs.");
  members("details", nlohmann::ordered_json::parse(metadata.detailsJson),
          "Free-form, as in the file: source, parameters, provenance.");
  members(
      "chunks", report.chunks,
      "The chunks of each type, in order of first appearance. The rest of the file is its header "
      "(24 bytes) and, if it has an index, the footer (40 bytes).",
      [](Members& own, const formats::T4dChunks& chunks) {
        own("type", chunks.type, "The type, such as SLAB.").notEmpty();
        own("count", chunks.count, "Number of chunks of this type.").atLeast(1);
        own("bytes", chunks.bytes, "Their bytes, including headers and padding.").atLeast(1);
      })
      .itemsFrom(1);
  members("bodies", bodiesOf(report),
          "Every body, in the order of the file. The members above are totals over all of them.",
          [](Members& own, const BodyInfo& body) {
            own("name", body.name, "Name of the body; names are unique.").notEmpty();
            addSummary(own, body.summary);
            own("slab_list", body.slabs, "With --slabs: the slabs in time order.", describeSlab)
                .itemsFrom(1)
                .onlyIf(!body.slabs.empty());
          })
      .itemsFrom(1);
}

}  // namespace t4d::verbs
