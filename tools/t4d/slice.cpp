#include "tools/t4d/slice.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "convert/frame_slices.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "model/parallel.h"
#include "slice/merge_coplanar.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"
#include "tools/t4d/centering.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/detail_text.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/material_names.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/origin.h"
#include "tools/t4d/slice_write_options.h"
#include "tools/t4d/slice_writing.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

using Sections = std::vector<formats::NamedMesh>;

slice::Hyperplane hyperplaneOf(const SliceOptions& options) {
  return options.time ? slice::Hyperplane::atTime(*options.time) : options.hyperplane;
}

/// The bodies that a slice can meet: for a slice at a time, those that exist then.
Result<std::vector<model::Body>> bodiesAt(const std::vector<model::Body>& bodies,
                                          const slice::Hyperplane& hyperplane) {
  if (!hyperplane.normal.head<3>().isZero(0) || bodies.size() == 1) return bodies;
  const double time = hyperplane.offset / hyperplane.normal[3];
  std::vector<model::Body> there;
  for (const model::Body& body : bodies) {
    if (model::timeWithin(*body.source, time)) there.push_back(body);
  }
  if (!there.empty()) return there;
  const model::TimeSpan span = model::timeSpanOf(bodies);
  return invalid(fmt::format("no body exists at time {}; the bodies last from {} to {}", time,
                             span.begin, span.end));
}

/// The slice of one body; notes in the report whether it is light.
Result<slice::LightSlice> sectionOf(const model::Body& body, const SliceOptions& options,
                                    SliceReport& report, const model::Progress& progress,
                                    Observer& observer) {
  const bool moves = options.write.needsVelocity();
  const auto withMotion = moves ? slice::WithMotion::Yes : slice::WithMotion::No;
  if (!options.light) {
    auto exact = moves ? slice::TimeSlicer(*body.source, withMotion).at(*options.time)
                       : slice::slice(*body.source, hyperplaneOf(options), progress);
    if (!exact) return exact.error();
    return slice::LightSlice{std::move(*exact), /*light=*/false, 0, {}};
  }
  auto made = slice::LightSlicer(*body.source, withMotion).at(*options.time);
  if (!made) return made.error();
  report.distance = std::max(report.distance, made->distance);
  if (!made->light) {
    report.light = false;
    observer.note(
        fmt::format("the slice of body '{}' is exact, because its slab does not consist "
                    "of prisms: {}",
                    body.name, made->whyExact));
  }
  return made;
}

/// Adds velocities if the options ask for them.
Result<void> addVelocityTo(slice::Slice& slice, const SliceOptions& options, SliceReport& report) {
  if (!slice.motion) return {};
  slice::VelocityOptions how;
  if (options.write.maxSpeed) how.most = *options.write.maxSpeed;
  const auto added = slice::addVelocity(slice, how);
  if (!added) return added.error();
  slice::VelocityReport& all = *report.velocity;
  all.volumeRate += added->volumeRate;
  all.maxSpeed = std::max(all.maxSpeed, added->maxSpeed);
  all.clamped += added->clamped;
  all.ofPoints = all.ofPoints && (added->ofPoints || slice.mesh.vertices.empty());
  return {};
}

Result<void> cutBodies(const Input& input, const SliceOptions& options, SliceReport& report,
                       Observer& observer) {
  const auto bodies = bodiesAt(input.bodies, hyperplaneOf(options));
  if (!bodies) return bodies.error();
  report.light = options.light;
  if (options.write.needsVelocity()) report.velocity = slice::VelocityReport{.ofPoints = true};
  const auto stage = observer.stage("slicing", slabCountOf(*bodies), "slabs");
  for (const model::Body& body : *bodies) {
    auto made = sectionOf(body, options, report, stage->part(body.source->slabCount()), observer);
    if (!made) return made.error();
    slice::Slice* slice = &made->slice;
    for (const model::Point3& vertex : slice->mesh.vertices) {
      if (vertex.allFinite()) continue;
      return invalid("the slice has coordinates beyond the range of doubles");
    }
    if (auto added = addVelocityTo(*slice, options, report); !added) return added.error();
    report.slabsRead += slice->slabsRead;
    report.slabsSkipped += slice->slabsSkipped;
    report.blocksRead += slice->blocksRead;
    if (options.write.attributes) {
      report.losses.insert(report.losses.end(), slice->losses.begin(), slice->losses.end());
    }
    report.sections.push_back(
        {.name = body.name, .mesh = std::move(slice->mesh), .ownCorners = made->light});
  }
  return {};
}

/// Where triangles are told apart by attributes, only those with the same ones are merged.
SliceMerge mergeSections(const SliceWriteOptions& write, Sections& sections) {
  const bool keepAttributes = write.attributes || write.isColoredByAttribute();
  SliceMerge merged;
  for (formats::NamedMesh& section : sections) {
    const auto one = slice::mergeCoplanar(section.mesh, keepAttributes);
    section.ownCorners = false;
    merged.trianglesBefore += one.trianglesBefore;
    merged.distance = std::max(merged.distance, one.distance);
  }
  return merged;
}

/// Colours the sections, and leaves out attributes that are not asked for.
Result<void> paintSections(const Input& input, const SliceOptions& options, SliceReport& report,
                           Observer& observer) {
  const SliceWriteOptions& write = options.write;
  const auto painting =
      write.isColoredBySpeed()   ? Result<Painting>(paintingBySpeed(report.velocity->maxSpeed))
      : write.isColoredByTrack() ? paintingByTrack(input, {&*options.time, 1}, observer)
                                 : paintingOf(write, input, report.sections);
  if (!painting) return painting.error();
  report.colorRange = painting->range;
  const auto velocity = frameVelocityOf(write, {});
  for (formats::NamedMesh& section : report.sections) {
    if (painting->paint) painting->paint(section, options.time.value_or(0));
    if (velocity) {
      convert::dropAttributes({.velocity = velocity, .attributes = write.attributes}, section.mesh);
    } else if (!write.attributes) {
      section.mesh.attributes.clear();
    }
  }
  return {};
}

/// Moves attributes that are points with the slice, and leaves out directions and points of space
/// where the slice has other axes. Returns a line for each that is left out.
Result<std::vector<std::string>> placeAttributes(Sections& sections,
                                                 const model::AttributeMeanings& meanings,
                                                 bool inSpace, const model::Point3& center) {
  model::Transform moved;
  moved.space.col(3) = -center;
  std::set<std::string> dropped;
  for (formats::NamedMesh& section : sections) {
    std::vector<model::Attribute>& attributes = section.mesh.attributes;
    std::erase_if(attributes, [&](const model::Attribute& attribute) {
      const bool drops = !inSpace && model::isSpatial(model::meaningOf(attribute, meanings));
      if (drops) dropped.insert(attribute.name);
      return drops;
    });
    for (model::Attribute& attribute : attributes) {
      const model::AttributeMeaning meaning = model::meaningOf(attribute, meanings);
      if (meaning.kind != "point") continue;
      if (auto done = model::mapValues(attribute, meaning, moved); !done) return done.error();
    }
  }
  std::vector<std::string> losses;
  for (const std::string& name : dropped) {
    losses.push_back(fmt::format(
        "attribute '{}': its values are in x, y and z, and the slice has other axes", name));
  }
  return losses;
}

formats::MeshWriteOptions writeOptionsOf(const Input& input, const SliceOptions& options,
                                         Observer& observer) {
  formats::MeshWriteOptions how{.attributes = options.write.attributes || options.write.velocity};
  model::Point4 origin;
  origin << originOf(input.metadata), 0;
  how.origin = slice::basisOf(hyperplaneOf(options)).axes * origin;
  how.normals = options.write.normals;
  how.time = options.time;
  how.materials = materialNamesOf(input.metadata);
  const auto* format = formats::triangleMeshFormat(options.output);
  if (format != nullptr && format->placed) {
    std::vector<std::string> notices;
    const formats::GltfPlacement placement = placementOf(input.metadata, notices);
    observer.noteEach(notices);
    // Only a slice at a time lies in space; others have time as an axis.
    if (options.time) how.placement = placement;
  }
  return how;
}

/// Writes the file, and adds to the losses of the report. The sections keep their attributes.
Result<void> writeSections(const Input& input, const SliceOptions& options,
                           const model::Bounds3& bounds, const formats::GltfEncoding& encoding,
                           SliceReport& report, Observer& observer) {
  const auto addLosses = [&](const std::vector<std::string>& losses) {
    report.losses.insert(report.losses.end(), losses.begin(), losses.end());
  };
  const model::Point3 center =
      options.write.center ? roundCenterOf(bounds) : model::Point3(model::Point3::Zero());
  std::vector<std::vector<model::Attribute>> asCut;
  if (options.write.attributes || options.write.velocity) {
    for (const formats::NamedMesh& section : report.sections) {
      asCut.push_back(section.mesh.attributes);
    }
    const auto placed = placeAttributes(report.sections, input.metadata.attributes,
                                        options.time.has_value(), center);
    if (!placed) return inInput(placed.error(), input);
    addLosses(*placed);
  }
  formats::MeshWriteOptions how = writeOptionsOf(input, options, observer);
  how.gltf = encoding;
  how.center = center;
  const auto written = formats::writeTriangleMeshes(options.output, report.sections, how);
  if (!written) return written.error();
  addLosses(*written);
  for (std::size_t i = 0; i < asCut.size(); ++i) {
    report.sections[i].mesh.attributes = std::move(asCut[i]);
  }
  return {};
}

void measureSections(SliceReport& report, Observer& observer) {
  for (const formats::NamedMesh& section : report.sections) {
    report.vertices += section.mesh.vertices.size();
    report.triangles += section.mesh.triangles.size();
    model::together([&] { report.volume += signedVolume(section.mesh); },
                    [&] { report.area += surfaceArea(section.mesh); },
                    [&] { report.closed = report.closed && isClosed(section.mesh); });
  }
  if (!std::isfinite(report.volume) || !std::isfinite(report.area)) {
    observer.note("coordinates are too large to measure volume or area");
  }
}

}  // namespace

Result<SliceReport> sliceMesh(const Input& input, const SliceOptions& options, Observer& observer) {
  SliceReport report;
  if (auto cut = cutBodies(input, options, report, observer); !cut) {
    return inInput(cut.error(), input);
  }
  if (options.mergeCoplanar) report.merge = mergeSections(options.write, report.sections);
  if (auto painted = paintSections(input, options, report, observer); !painted) {
    return inInput(painted.error(), input);
  }
  model::Bounds3 bounds;
  for (const formats::NamedMesh& section : report.sections) {
    bounds.add(model::boundsOf(section.mesh));
  }
  const formats::GltfEncoding encoding = gltfEncodingOf(options.write, bounds);
  report.quantizationError = quantizationErrorOf(encoding);
  if (!options.output.empty()) {
    auto written = writeSections(input, options, bounds, encoding, report, observer);
    if (!written) return written.error();
  }
  measureSections(report, observer);
  if (input.reader) {
    report.bytesRead = input.reader->bytesRead();
    report.requests = input.reader->requests();
  }
  return report;
}

void describe(Members& members, const SliceReport& report) {
  const auto ofVelocity = [&]<class T>(T slice::VelocityReport::*member) {
    return report.velocity ? std::optional<T>((*report.velocity).*member) : std::nullopt;
  };
  members("vertices", report.vertices, "Vertices of the slice; 0 if the hyperplane meets nothing.");
  members("triangles", report.triangles, "Triangles of the slice.");
  members("closed", report.closed,
          "Whether every edge has two triangles, in opposite directions; true for an empty slice.");
  members(
      "volume", report.closed ? std::optional(report.volume) : std::nullopt,
      "Enclosed volume, positive if triangles face outward; null if the slice is not closed, or "
      "if it is too large for a double.");
  members("area", report.area, "Area of all triangles; null if it is too large for a double.")
      .atLeast(0)
      .orNull();
  members("slabs_read", report.slabsRead, "Slabs that were decoded, whole or in part.");
  members("slabs_skipped", report.slabsSkipped,
          "Slabs that were not read, because the hyperplane misses their times or bounds.");
  members("blocks_read", report.blocksRead, "Blocks of at most 65,536 cells that were decoded.");
  members("bytes_read", report.bytesRead,
          "Bytes of the file that were read, including header and index; for a web server, bytes "
          "received.");
  members("requests", report.requests, "Requests made to a web server; 0 for a local file.");
  members("light", report.light,
          "Whether the slice, in all bodies, has the triangles of the layers (a light slice).");
  members("distance", report.distance,
          "Bound on the Hausdorff distance of a light slice from the exact slice, in length units; "
          "0 if all are exact, null if it is too large for a double.")
      .atLeast(0)
      .orNull();
  members(
      "volume_rate", ofVelocity(&slice::VelocityReport::volumeRate),
      "The rate at which the volume of the slice changes at its time, in cubed length units per "
      "time unit: the sum of area times speed over its triangles; null without velocities.");
  members("max_speed", ofVelocity(&slice::VelocityReport::maxSpeed),
          "Largest speed of a vertex, as written, in length units per time unit; null without "
          "velocities.")
      .atLeast(0);
  members("clamped", ofVelocity(&slice::VelocityReport::clamped),
          "Number of vertices that --max-speed slowed down; null without velocities.");
  const auto ofPoints = ofVelocity(&slice::VelocityReport::ofPoints);
  members(
      "velocity_of",
      ofPoints ? std::optional<std::string>(*ofPoints ? "points" : "surface") : std::nullopt,
      "Whether the velocities are those of points of the solid, known for a swept mesh, or those "
      "of its surface along its normals; null without velocities.")
      .oneOf({"points", "surface"});
  addLooks(members, report.colorRange, report.quantizationError);
  members(
      "merge_distance", report.merge ? std::optional(report.merge->distance) : std::nullopt,
      "Bound on the Hausdorff distance between the surfaces before and after coplanar triangles "
      "were merged, in the units of the slice's axes; 0 up to rounding, null if they were not "
      "merged.")
      .atLeast(0);
}

namespace {

struct SliceArguments {
  std::string input;
  InputOptions only;
  std::optional<double> x;
  std::optional<double> y;
  std::optional<double> z;
  std::vector<double> hyperplane;
  std::string coplanar = "keep";
  SliceOptions slice;
  bool json = false;
};

/// The hyperplane that is given in place of a time; CLI11 has checked that there is exactly one.
slice::Hyperplane hyperplaneWithoutTime(const SliceArguments& options) {
  if (options.x) return slice::Hyperplane::across(0, *options.x);
  if (options.y) return slice::Hyperplane::across(1, *options.y);
  if (options.z) return slice::Hyperplane::across(2, *options.z);
  const auto& n = options.hyperplane;
  return {{n[0], n[1], n[2], n[3]}, n[4]};
}

/// Why these options cannot be.
std::optional<std::string> misuseOf(const SliceArguments& options) {
  const SliceOptions& how = options.slice;
  const std::string& color = how.write.color;
  if ((color == "time" || color == "speed" || color == "track") && !how.time) {
    return fmt::format("--color {}: colours are those of a slice at a time (--time)", color);
  }
  if (color == "track" && how.light) return "--color track: not with --light";
  if (auto misuse = misuseOfMaxSpeed(how.write)) return misuse;
  if (const auto checked = slice::checkHyperplane(hyperplaneOf(how)); !checked) {
    return "--hyperplane: " + checked.error().message;
  }
  return how.output.empty() ? std::nullopt : misuseOfEncoding(how.write, how.output);
}

void printReport(const SliceArguments& options, const Input& input, const SliceReport& made) {
  const SliceOptions& how = options.slice;
  print("{}{}, {}, {}area {:.12g}\n", how.output.empty() ? "" : how.output + ": ",
        counted(made.vertices, "vertex", "vertices"), counted(made.triangles, "triangle"),
        made.closed ? fmt::format("closed; volume {:.12g}, ", made.volume) : "NOT CLOSED; ",
        made.area);
  print("  read {} of {}, {}{}\n", sizeText(made.bytesRead), sizeText(input.reader->fileBytes()),
        counted(made.slabsRead, "slab"),
        made.requests > 0 ? ", in " + counted(made.requests, "request") : "");
  if (how.light) print("  {}\n", detailText(made.light, made.distance));
  const slice::VelocityReport velocity = made.velocity.value_or(slice::VelocityReport());
  const std::string unit = velocityUnit(input.metadata, /*ofPlayback=*/false);
  printExtra(
      {velocityText(how.write, velocity.maxSpeed, velocity.clamped, unit),
       how.write.velocity
           ? fmt::format("the volume changes by {:.12g} per time unit; velocities are of "
                         "the {}",
                         velocity.volumeRate, velocity.ofPoints ? "points" : "surface")
           : "",
       made.merge ? fmt::format("coplanar triangles merged: {} before; no point moved further "
                                "than {:.3g}",
                                grouped(made.merge->trianglesBefore), made.merge->distance)
                  : "",
       colorText(how.write, made.colorRange), quantizationText(how.write, made.quantizationError)});
}

int run(SliceArguments& options) {
  if (!options.slice.time) options.slice.hyperplane = hyperplaneWithoutTime(options);
  options.slice.mergeCoplanar = options.coplanar == "merge";
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  ConsoleObserver observer;
  const auto made = sliceMesh(*input, options.slice, observer);
  if (!made) return report(made.error());
  if (options.json) {
    printAsJson(*made);
  } else {
    printReport(options, *input, *made);
  }
  if (made->triangles == 0) {
    printNotices({"the slice is empty: the solid does not reach this hyperplane"});
  }
  return reportLosses(made->losses, options.slice.write.center);
}

}  // namespace

void addSlice(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("slice", "Cut a 4D mesh at a time or by another hyperplane");
  auto options = std::make_shared<SliceArguments>();
  SliceOptions& slice = options->slice;
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  auto* cuts = command->add_option_group("hyperplane", "Hyperplane (exactly one)");
  cuts->add_option("-t,--time", slice.time, "Section at time V; coordinates (x, y, z)")
      ->check(finiteNumber());
  cuts->add_option("--x", options->x, "Section at x = V; coordinates (y, z, t)")
      ->check(finiteNumber());
  cuts->add_option("--y", options->y, "Section at y = V; coordinates (x, z, t)")
      ->check(finiteNumber());
  cuts->add_option("--z", options->z, "Section at z = V; coordinates (x, y, t)")
      ->check(finiteNumber());
  addNumbers(*cuts, "--hyperplane", options->hyperplane,
             "Section at A x + B y + C z + D t = OFFSET (coordinates: docs/slice.md)", 5, 5,
             "A,B,C,D,OFFSET");
  cuts->require_option(1);
  command
      ->add_option("-o,--output", slice.output,
                   fmt::format("Output file: {} (default: none, only measure)",
                               formats::writableTriangleMeshExtensions()))
      ->check(someName())
      ->check(writableTriangleMesh());
  options->only.addTo(*command);
  command
      ->add_flag("--light", slice.light,
                 "Interpolate the triangles of the layers: up to 13 times fewer, same volume")
      ->needs("--time");
  command
      ->add_option("--coplanar", options->coplanar,
                   "Keep coplanar triangles, or merge them into fewer")
      ->check(CLI::IsMember({"keep", "merge"}))
      ->capture_default_str();
  addSliceWriteOptions(*command, slice.write);
  command->get_option("--velocity")->needs("--time");
  addCenterOption(*command, slice.write.center);
  addJsonOption<SliceReport>(
      *command, options->json,
      "The slice of all bodies together. Volume and area are in the units of the slice's three "
      "axes: lengths for a slice at a time; for other slices one axis is time.");
  command->footer("Example:\n  t4d slice bolt.t4d --time 2.5 -o bolt-at-2.5.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
