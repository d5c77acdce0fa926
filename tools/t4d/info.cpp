#include "tools/t4d/info.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/origin.h"

namespace t4d::tools {
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

namespace {

/// For a file made by `t4d recover`: its source and what is missing; otherwise empty.
std::string recoveredText(const std::string& detailsJson) {
  try {
    const ordered_json details = ordered_json::parse(detailsJson);
    const ordered_json& noted = details.at("recovered");
    std::string text = fmt::format("recovered from {}: ", noted.at("from").get<std::string>());
    text += grouped(noted.at("slabs_saved").get<std::uint64_t>());
    if (noted.contains("slabs_known")) {
      text += " of " + grouped(noted.at("slabs_known").get<std::uint64_t>());
    }
    text += " slabs";
    const ordered_json gaps = noted.value("gaps", ordered_json::array());
    if (gaps.empty()) return text;
    return text +
           fmt::format("; nothing between time {} and {}{}", gaps.at(0).at("begin").get<double>(),
                       gaps.at(0).at("end").get<double>(),
                       gaps.size() > 1 ? fmt::format(", and {} more gaps", gaps.size() - 1) : "");
  } catch (const ordered_json::exception&) {
    return {};  // details may have any members
  }
}

void printChunks(const InfoReport& report) {
  std::vector<std::vector<std::string>> rows = {{"  chunks", "number", "size"}};
  for (const formats::T4dChunks& chunks : report.chunks) {
    rows.push_back({"  " + chunks.type, grouped(chunks.count), sizeText(chunks.bytes)});
  }
  printTable(rows, "lr");
}

void printSlabs(const std::string& body, const std::vector<formats::T4dSlab>& slabs) {
  print("  slabs of the body '{}'\n", body);
  std::vector<std::vector<std::string>> rows = {
      {"  slab", "begin", "end", "cells", "x", "to", "y", "to", "z", "to"}};
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    const formats::T4dSlab& slab = slabs[i];
    rows.push_back({fmt::format("  {}", i), fmt::format("{}", slab.time.begin),
                    fmt::format("{}", slab.time.end), grouped(slab.cells)});
    for (int axis = 0; axis < 3; ++axis) {
      for (const model::Point3& corner : {slab.bounds.min, slab.bounds.max}) {
        const double value = corner[axis];
        rows.back().push_back(std::isfinite(value) ? fmt::format("{:.6g}", value) : "-");
      }
    }
  }
  printTable(rows, "lr");
}

void printReport(const InfoReport& report) {
  const formats::Metadata& metadata = report.metadata;
  const formats::BodySummary all = report.total();
  const auto unit = [](const std::string& name) { return name.empty() ? name : " " + name; };
  print("{}: .t4d {}.{}, {}, by {}{}\n", report.name, report.version.major, report.version.minor,
        sizeText(report.bytes),
        metadata.generator.empty() ? "an unknown program" : metadata.generator,
        metadata.backend.empty() ? "" : " (" + metadata.backend + ")");
  print("  {}, {} in {}\n", counted(all.vertices, "vertex", "vertices"),
        counted(all.tetrahedra, "tetrahedron", "tetrahedra"), counted(all.slabs, "slab"));
  print("  time {} to {}{}\n", all.time.begin, all.time.end, unit(metadata.timeUnit));
  const model::Point3& low = all.bounds.min;
  const model::Point3& high = all.bounds.max;
  print("  x {:.6g} to {:.6g}, y {:.6g} to {:.6g}, z {:.6g} to {:.6g}{}; {} is up\n", low.x(),
        high.x(), low.y(), high.y(), low.z(), high.z(), unit(metadata.lengthUnit), metadata.up);
  if (!metadata.space.empty()) print("  axes point as in {}\n", metadata.space);
  for (const auto& [name, meaning] : metadata.attributes) {
    print("  attribute '{}': {}{}\n", name, meaning.kind.empty() ? "scalar" : meaning.kind,
          meaning.unit.empty() ? "" : " in " + meaning.unit);
  }
  for (std::size_t i = 0; i < report.bodies.size(); ++i) {
    const formats::BodySummary& body = report.bodies[i];
    print("  body '{}': {}, time {} to {}\n", metadata.bodies[i].name,
          counted(body.tetrahedra, "tetrahedron", "tetrahedra"), body.time.begin, body.time.end);
  }
  if (const model::Point3 origin = originOf(metadata); !origin.isZero(0)) {
    print("  its origin is at ({}, {}, {}) of the original coordinates\n", origin.x(), origin.y(),
          origin.z());
  }
  const std::string recovered = recoveredText(metadata.detailsJson);
  if (!recovered.empty()) print("  {}\n", recovered);
  printChunks(report);
  for (std::size_t i = 0; i < report.slabs.size(); ++i) {
    printSlabs(metadata.bodies[i].name, report.slabs[i]);
  }
}

int run(const std::string& path, const InfoOptions& options, bool json) {
  const auto done = info(path, options);
  if (!done) return report(done.error());
  if (json) {
    printAsJson(*done);
  } else {
    printReport(*done);
  }
  return kDone;
}

}  // namespace

void addInfo(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("info", "Print what a .t4d file contains, from its header and index");
  auto path = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  auto options = std::make_shared<InfoOptions>();
  command->add_option("FILE", *path, std::string(kT4dFileHelp) + kOrPipeHelp)->required();
  command->add_flag("--slabs", options->slabs, "Also list the slabs: times, cells and bounds");
  addJsonOption<InfoReport>(*command, *json,
                            "The contents of a .t4d file, from its header and index. "
                            "Lengths are in length_unit, times in time_unit.");
  command->footer("Example:\n  t4d info bolt.t4d");
  command->callback([=, &exitCode] { exitCode = run(*path, *options, *json); });
}

}  // namespace t4d::tools
