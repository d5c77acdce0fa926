#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/reader.h"
#include "tools/program/centering.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"

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

int run(const std::string& path, bool json) {
  auto reader = formats::T4dReader::open(path, formats::T4dOpen::Whole, {}, formats::kAnyCells);
  if (!reader) return report(reader.error());
  const formats::Metadata& metadata = reader->metadata();
  formats::BodySummary all = reader->summary(0);
  for (std::size_t i = 1; i < reader->bodyCount(); ++i) {
    const formats::BodySummary& body = reader->summary(i);
    all.slabs += body.slabs;
    all.vertices += body.vertices;
    all.tetrahedra += body.tetrahedra;
    all.time = {std::min(all.time.begin, body.time.begin), std::max(all.time.end, body.time.end)};
    if (body.vertices > 0) all.bounds.add(body.bounds);
  }
  const std::string version =
      fmt::format("{}.{}", reader->version().major, reader->version().minor);
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
                          {"bytes", reader->fileBytes()},
                          {"up", metadata.up},
                          {"indexed", reader->indexed()},
                          {"details", ordered_json::parse(metadata.detailsJson)}};
    for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
      const formats::BodySummary& body = reader->summary(i);
      value["bodies"].push_back({{"name", metadata.bodies[i].name},
                                 {"slabs", body.slabs},
                                 {"vertices", body.vertices},
                                 {"tetrahedra", body.tetrahedra},
                                 {"time_begin", body.time.begin},
                                 {"time_end", body.time.end},
                                 {"bounds_min", triple(body.bounds.min)},
                                 {"bounds_max", triple(body.bounds.max)}});
    }
    printJson(value);
    return kDone;
  }
  const auto unit = [](const std::string& name) { return name.empty() ? name : " " + name; };
  print("{}: .t4d {}, {}, by {}{}\n", path, version, sizeText(reader->fileBytes()),
        metadata.generator.empty() ? "an unknown program" : metadata.generator,
        metadata.backend.empty() ? "" : " (" + metadata.backend + ")");
  print("  {}, {} in {}\n", counted(all.vertices, "vertex", "vertices"),
        counted(all.tetrahedra, "tetrahedron", "tetrahedra"), counted(all.slabs, "slab"));
  print("  time {} to {}{}\n", all.time.begin, all.time.end, unit(metadata.timeUnit));
  const model::Point3& low = all.bounds.min;
  const model::Point3& high = all.bounds.max;
  print("  x {:.6g} to {:.6g}, y {:.6g} to {:.6g}, z {:.6g} to {:.6g}{}; {} is up\n", low.x(),
        high.x(), low.y(), high.y(), low.z(), high.z(), unit(metadata.lengthUnit), metadata.up);
  for (std::size_t i = 0; i < reader->bodyCount(); ++i) {
    const formats::BodySummary& body = reader->summary(i);
    print("  body '{}': {}, time {} to {}\n", metadata.bodies[i].name,
          counted(body.tetrahedra, "tetrahedron", "tetrahedra"), body.time.begin, body.time.end);
  }
  if (const model::Point3 origin = originOf(metadata); !origin.isZero(0)) {
    print("  its origin is at ({}, {}, {}) of the original coordinates\n", origin.x(), origin.y(),
          origin.z());
  }
  const std::string recovered = recoveredText(metadata.detailsJson);
  if (!recovered.empty()) print("  {}\n", recovered);
  return kDone;
}

}  // namespace

void addInfo(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "info", "Print what a .t4d file contains, from its header and index alone");
  auto path = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  command->add_option("FILE", *path, "The .t4d file")->required();
  command->add_flag("--json", *json, "Print JSON");
  command->footer("Example:\n  t4d info bolt.t4d");
  command->callback([=, &exitCode] { exitCode = run(*path, *json); });
}

}  // namespace t4d::tools
