#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/verbs/info.h"
#include "tools/verbs/origin.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

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

void printChunks(const verbs::InfoReport& report) {
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

void printReport(const verbs::InfoReport& report) {
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
  if (const model::Point3 origin = verbs::originOf(metadata); !origin.isZero(0)) {
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

int run(const std::string& path, const verbs::InfoOptions& options, bool json) {
  const auto done = verbs::info(path, options);
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
  auto options = std::make_shared<verbs::InfoOptions>();
  command->add_option("FILE", *path, std::string(kT4dFileHelp) + kOrPipeHelp)->required();
  command->add_flag("--slabs", options->slabs, "Also list the slabs: times, cells and bounds");
  addJsonOption<verbs::InfoReport>(*command, *json,
                                   "The contents of a .t4d file, from its header and index. "
                                   "Lengths are in length_unit, times in time_unit.");
  command->footer("Example:\n  t4d info bolt.t4d");
  command->callback([=, &exitCode] { exitCode = run(*path, *options, *json); });
}

}  // namespace t4d::tools
