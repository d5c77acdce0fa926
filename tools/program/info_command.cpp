#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/reader.h"
#include "t4d/formats/t4d/stream.h"
#include "t4d/verbs/origin.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_options.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

ordered_json triple(const model::Point3& point) { return {point.x(), point.y(), point.z()}; }

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

/// What the slabs of each body contain.
using SlabLists = std::vector<std::vector<formats::T4dSlab>>;

Result<SlabLists> slabsOf(const formats::T4dReader& reader) {
  SlabLists slabs(reader.bodyCount());
  for (std::size_t body = 0; body < slabs.size(); ++body) {
    for (std::size_t i = 0; i < reader.body(body).slabCount(); ++i) {
      auto slab = reader.slabContents(body, i);
      if (!slab) return slab.error();
      slabs[body].push_back(*slab);
    }
  }
  return slabs;
}

/// Reads the stream to its end.
Result<SlabLists> slabsOf(formats::T4dStream& stream) {
  SlabLists slabs(stream.bodyCount());
  while (true) {
    const auto item = stream.next();
    if (!item) return item.error();
    if (!*item) return slabs;
    const model::Slab& slab = *(*item)->slab;
    formats::T4dSlab contents = {
        {slab.timeBegin, slab.timeEnd}, slab.connectivity->cells.size(), {}};
    for (const model::Point4& vertex : slab.vertices) contents.bounds.add(vertex.head<3>());
    slabs[(*item)->body].push_back(contents);
  }
}

template <class File>
void printChunks(const File& reader) {
  std::vector<std::vector<std::string>> rows = {{"  chunks", "number", "size"}};
  for (const formats::T4dChunks& chunks : reader.chunks()) {
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

/// Prints what a reader, or a stream that has ended, tells.
template <class File>
void printInfo(const File& reader, const SlabLists& slabs, bool json) {
  const formats::Metadata& metadata = reader.metadata();
  formats::BodySummary all = reader.summary(0);
  for (std::size_t i = 1; i < reader.bodyCount(); ++i) {
    const formats::BodySummary& body = reader.summary(i);
    all.slabs += body.slabs;
    all.vertices += body.vertices;
    all.tetrahedra += body.tetrahedra;
    all.time = {std::min(all.time.begin, body.time.begin), std::max(all.time.end, body.time.end)};
    if (body.vertices > 0) all.bounds.add(body.bounds);
  }
  const std::string version = fmt::format("{}.{}", reader.version().major, reader.version().minor);
  if (json) {
    ordered_json value = {{"format_version", version},
                          {"generator", metadata.generator},
                          {"backend", metadata.backend},
                          {"slabs", all.slabs},
                          {"vertices", all.vertices},
                          {"tetrahedra", all.tetrahedra},
                          {"time_begin", all.time.begin},
                          {"time_end", all.time.end},
                          {"bounds_min", triple(all.bounds.min)},
                          {"bounds_max", triple(all.bounds.max)},
                          {"length_unit", metadata.lengthUnit},
                          {"time_unit", metadata.timeUnit},
                          {"bytes", reader.fileBytes()},
                          {"up", metadata.up},
                          {"space", metadata.space},
                          {"attributes", ordered_json::object()},
                          {"indexed", reader.indexed()},
                          {"details", ordered_json::parse(metadata.detailsJson)}};
    for (const auto& [name, meaning] : metadata.attributes) {
      value["attributes"][name] = {{"kind", meaning.kind.empty() ? "scalar" : meaning.kind},
                                   {"unit", meaning.unit}};
    }
    for (const formats::T4dChunks& chunks : reader.chunks()) {
      value["chunks"].push_back(
          {{"type", chunks.type}, {"count", chunks.count}, {"bytes", chunks.bytes}});
    }
    for (std::size_t i = 0; i < reader.bodyCount(); ++i) {
      const formats::BodySummary& body = reader.summary(i);
      value["bodies"].push_back({{"name", metadata.bodies[i].name},
                                 {"slabs", body.slabs},
                                 {"vertices", body.vertices},
                                 {"tetrahedra", body.tetrahedra},
                                 {"time_begin", body.time.begin},
                                 {"time_end", body.time.end},
                                 {"bounds_min", triple(body.bounds.min)},
                                 {"bounds_max", triple(body.bounds.max)}});
      if (slabs.empty()) continue;
      for (const formats::T4dSlab& slab : slabs[i]) {
        value["bodies"].back()["slab_list"].push_back(
            {{"begin", slab.time.begin},
             {"end", slab.time.end},
             {"cells", slab.cells},
             {"bounds", {{"min", triple(slab.bounds.min)}, {"max", triple(slab.bounds.max)}}}});
      }
    }
    printJson(value);
    return;
  }
  const auto unit = [](const std::string& name) { return name.empty() ? name : " " + name; };
  print("{}: .t4d {}, {}, by {}{}\n", reader.name(), version, sizeText(reader.fileBytes()),
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
  for (std::size_t i = 0; i < reader.bodyCount(); ++i) {
    const formats::BodySummary& body = reader.summary(i);
    print("  body '{}': {}, time {} to {}\n", metadata.bodies[i].name,
          counted(body.tetrahedra, "tetrahedron", "tetrahedra"), body.time.begin, body.time.end);
  }
  if (const model::Point3 origin = verbs::originOf(metadata); !origin.isZero(0)) {
    print("  its origin is at ({}, {}, {}) of the original coordinates\n", origin.x(), origin.y(),
          origin.z());
  }
  const std::string recovered = recoveredText(metadata.detailsJson);
  if (!recovered.empty()) print("  {}\n", recovered);
  printChunks(reader);
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    printSlabs(metadata.bodies[i].name, slabs[i]);
  }
}

int run(const std::string& path, bool listSlabs, bool json) {
  if (formats::isPipe(path)) {
    auto stream = formats::T4dStream::open(path, formats::kAnyCells);
    if (!stream) return report(stream.error());
    const auto slabs = slabsOf(*stream);
    if (!slabs) return report(slabs.error());
    printInfo(*stream, listSlabs ? *slabs : SlabLists(), json);
    return kDone;
  }
  auto reader = formats::T4dReader::open(path, formats::T4dOpen::Whole, {}, formats::kAnyCells);
  if (!reader) return report(reader.error());
  const auto slabs = listSlabs ? slabsOf(*reader) : SlabLists();
  if (!slabs) return report(slabs.error());
  printInfo(*reader, *slabs, json);
  return kDone;
}

}  // namespace

void addInfo(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("info", "Print what a .t4d file contains, from its header and index");
  auto path = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  auto slabs = std::make_shared<bool>(false);
  command->add_option("FILE", *path, std::string(kT4dFileHelp) + kOrPipeHelp)->required();
  command->add_flag("--slabs", *slabs, "Also list the slabs: times, cells and bounds");
  command->add_flag("--json", *json, "Print JSON");
  command->footer("Example:\n  t4d info bolt.t4d");
  command->callback([=, &exitCode] { exitCode = run(*path, *slabs, *json); });
}

}  // namespace t4d::tools
