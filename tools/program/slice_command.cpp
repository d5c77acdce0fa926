#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/parallel_invoke.h>

#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/model/transformed.h"
#include "t4d/slice/light_slice.h"
#include "t4d/slice/merge_coplanar.h"
#include "t4d/slice/slice.h"
#include "t4d/slice/velocity.h"
#include "t4d/verbs/origin.h"
#include "tools/program/appearance.h"
#include "tools/program/centering.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/detail_text.h"
#include "tools/program/gltf_options.h"
#include "tools/program/input_options.h"
#include "tools/program/numbers.h"
#include "tools/program/option_checks.h"
#include "tools/program/velocity_options.h"

namespace t4d::tools {
namespace {

struct SliceArguments {
  std::string input;
  std::string output;
  std::optional<double> time;
  std::optional<double> x;
  std::optional<double> y;
  std::optional<double> z;
  std::vector<double> hyperplane;
  InputOptions only;
  Appearance appearance;
  VelocityOptions velocity;
  GltfOptions gltf;
  std::string coplanar = "keep";
  bool light = false;
  bool attributes = false;
  bool center = false;
  bool json = false;
};

/// The hyperplane given by the options; CLI11 has checked that there is exactly one.
slice::Hyperplane hyperplaneOf(const SliceArguments& options) {
  if (options.time) return slice::Hyperplane::atTime(*options.time);
  if (options.x) return slice::Hyperplane::across(0, *options.x);
  if (options.y) return slice::Hyperplane::across(1, *options.y);
  if (options.z) return slice::Hyperplane::across(2, *options.z);
  const auto& n = options.hyperplane;
  return {{n[0], n[1], n[2], n[3]}, n[4]};
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

struct Sections {
  std::vector<formats::NamedMesh> meshes;
  std::vector<std::string> losses;
  std::uint64_t slabsRead = 0;
  std::uint64_t slabsSkipped = 0;
  std::uint64_t blocksRead = 0;
  bool light = false;
  double distance = 0;
  slice::VelocityReport velocity;  // of all bodies; ofPoints if all are
};

/// The slice of one body; notes in `sections` whether it is light.
Result<slice::LightSlice> sliceOf(const model::Body& body, const slice::Hyperplane& hyperplane,
                                  const SliceArguments& options, Sections& sections,
                                  const model::Progress& progress) {
  const bool moves = options.velocity.isNeeded(options.appearance);
  const auto withMotion = moves ? slice::WithMotion::Yes : slice::WithMotion::No;
  if (!options.light) {
    auto exact = moves ? slice::TimeSlicer(*body.source, withMotion).at(hyperplane.offset)
                       : slice::slice(*body.source, hyperplane, progress);
    if (!exact) return exact.error();
    return slice::LightSlice{std::move(*exact), /*light=*/false, 0, {}};
  }
  auto made = slice::LightSlicer(*body.source, withMotion).at(hyperplane.offset);
  if (!made) return made.error();
  sections.distance = std::max(sections.distance, made->distance);
  if (!made->light) {
    sections.light = false;
    printNotices(
        {fmt::format("the slice of body '{}' is exact, because its slab does not consist "
                     "of prisms: {}",
                     body.name, made->whyExact)});
  }
  return made;
}

/// If the options ask for it.
Result<void> addVelocity(slice::Slice& slice, const SliceArguments& options, Sections& sections) {
  if (!slice.motion) return {};
  slice::VelocityOptions how;
  if (options.velocity.maxSpeed) how.most = *options.velocity.maxSpeed;
  const auto added = slice::addVelocity(slice, how);
  if (!added) return added.error();
  slice::VelocityReport& all = sections.velocity;
  all.volumeRate += added->volumeRate;
  all.maxSpeed = std::max(all.maxSpeed, added->maxSpeed);
  all.clamped += added->clamped;
  all.ofPoints = all.ofPoints && (added->ofPoints || slice.mesh.vertices.empty());
  return {};
}

Result<Sections> cut(const verbs::Input& input, const slice::Hyperplane& hyperplane,
                     const SliceArguments& options) {
  auto bodies = bodiesAt(input.bodies, hyperplane);
  if (!bodies) return bodies.error();
  Sections sections;
  sections.light = options.light;
  sections.velocity.ofPoints = true;
  ProgressBar bar("slicing", verbs::slabCountOf(*bodies), "slabs");
  for (const model::Body& body : *bodies) {
    auto made = sliceOf(body, hyperplane, options, sections, bar.part(body.source->slabCount()));
    if (!made) return made.error();
    slice::Slice* slice = &made->slice;
    for (const model::Point3& vertex : slice->mesh.vertices) {
      if (vertex.allFinite()) continue;
      return invalid("the slice has coordinates beyond the range of doubles");
    }
    if (auto added = addVelocity(*slice, options, sections); !added) return added.error();
    sections.slabsRead += slice->slabsRead;
    sections.slabsSkipped += slice->slabsSkipped;
    sections.blocksRead += slice->blocksRead;
    sections.losses.insert(sections.losses.end(), slice->losses.begin(), slice->losses.end());
    sections.meshes.push_back(
        {.name = body.name, .mesh = std::move(slice->mesh), .ownCorners = made->light});
  }
  return sections;
}

model::Bounds3 boundsOf(const Sections& sections) {
  model::Bounds3 bounds;
  for (const formats::NamedMesh& section : sections.meshes) {
    bounds.add(model::boundsOf(section.mesh));
  }
  return bounds;
}

struct Merged {
  std::uint64_t before = 0;  // triangles
  double distance = 0;
};

/// Where triangles are told apart by attributes, only those with the same ones are merged.
Merged mergeCoplanar(const SliceArguments& options, Sections& sections) {
  const std::string& color = options.appearance.color;
  const bool byAttribute = color == "triangle" || color.starts_with("attribute:");
  Merged merged;
  for (formats::NamedMesh& section : sections.meshes) {
    const auto one = slice::mergeCoplanar(section.mesh, options.attributes || byAttribute);
    section.ownCorners = false;
    merged.before += one.trianglesBefore;
    merged.distance = std::max(merged.distance, one.distance);
  }
  return merged;
}

/// Moves attributes that are points with the slice, and leaves out directions and points of space
/// where the slice has other axes. Returns a line for each that is left out.
Result<std::vector<std::string>> placeAttributes(Sections& sections,
                                                 const model::AttributeMeanings& meanings,
                                                 bool inSpace, const model::Point3& center) {
  model::Transform moved;
  moved.space.col(3) = -center;
  std::set<std::string> dropped;
  for (formats::NamedMesh& section : sections.meshes) {
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

Result<std::vector<std::string>> write(const SliceArguments& options, const Sections& sections,
                                       const slice::Hyperplane& hyperplane,
                                       const formats::Metadata& metadata,
                                       const formats::GltfEncoding& encoding,
                                       const model::Point3& center) {
  formats::MeshWriteOptions how{.attributes = options.attributes || options.velocity.velocity};
  model::Point4 origin;
  origin << verbs::originOf(metadata), 0;
  how.origin = slice::basisOf(hyperplane).axes * origin;
  how.normals = options.appearance.normalStyle();
  how.time = options.time;
  how.gltf = encoding;
  how.center = center;
  if (formats::triangleMeshFormat(options.output)->placed) {
    std::vector<std::string> notices;
    const formats::GltfPlacement placement = verbs::placementOf(metadata, notices);
    printNotices(notices);
    // Only a slice at a time lies in space; others have time as an axis.
    if (options.time) how.placement = placement;
  }
  return formats::writeTriangleMeshes(options.output, sections.meshes, how);
}

std::string velocityOf(const slice::VelocityReport& report) {
  return report.ofPoints ? "points" : "surface";
}

int run(const SliceArguments& options) {
  if (const auto misuse = misuseOfOutput(options.output, {&options.input, 1})) {
    return wrongUsage(*misuse);
  }
  const std::string& color = options.appearance.color;
  if ((color == "time" || color == "speed") && !options.time) {
    return wrongUsage(
        fmt::format("--color {}: colours are those of a slice at a time (--time)", color));
  }
  if (const auto misuse = options.velocity.misuse(options.appearance)) return wrongUsage(*misuse);
  const slice::Hyperplane hyperplane = hyperplaneOf(options);
  if (const auto checked = slice::checkHyperplane(hyperplane); !checked) {
    return wrongUsage("--hyperplane: " + checked.error().message);
  }
  if (!options.output.empty()) {
    if (const auto misuse = options.gltf.misuse(options.output)) return wrongUsage(*misuse);
  }
  auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  auto sections = cut(*input, hyperplane, options);
  if (!sections) {
    return report(inInput(sections.error(), *input));
  }
  std::optional<Merged> merged;
  if (options.coplanar == "merge") merged = mergeCoplanar(options, *sections);
  const Appearance& looks = options.appearance;
  auto painting =
      looks.isBySpeed()
          ? speedPainting(sections->velocity.maxSpeed)
          : looks.painting(input->metadata, model::timeSpanOf(input->bodies), sections->meshes);
  if (!painting) return report(inInput(painting.error(), *input));
  for (formats::NamedMesh& section : sections->meshes) {
    if (painting->paint) painting->paint(section, options.time.value_or(0));
    convert::dropAttributes({.velocity = options.velocity.ofFrames(options.appearance, {}),
                             .attributes = options.attributes},
                            section.mesh);
  }
  const formats::GltfEncoding encoding = options.gltf.encoding(boundsOf(*sections));
  std::vector<std::string> losses;
  if (options.attributes) losses = sections->losses;
  if (!options.output.empty()) {
    const formats::Metadata& metadata = input->metadata;
    const model::Point3 center =
        options.center ? verbs::roundCenterOf(boundsOf(*sections)) : model::Point3(0, 0, 0);
    if (options.attributes || options.velocity.velocity) {
      auto placed =
          placeAttributes(*sections, metadata.attributes, options.time.has_value(), center);
      if (!placed) return report(inInput(placed.error(), *input));
      losses.insert(losses.end(), placed->begin(), placed->end());
    }
    auto written = write(options, *sections, hyperplane, metadata, encoding, center);
    if (!written) return report(written.error());
    losses.insert(losses.end(), written->begin(), written->end());
  }

  std::size_t vertices = 0;
  std::size_t triangles = 0;
  double volume = 0;
  double area = 0;
  bool closed = true;
  for (const formats::NamedMesh& section : sections->meshes) {
    vertices += section.mesh.vertices.size();
    triangles += section.mesh.triangles.size();
    tbb::parallel_invoke([&] { volume += signedVolume(section.mesh); },
                         [&] { area += surfaceArea(section.mesh); },
                         [&] { closed = closed && isClosed(section.mesh); });
  }
  if (!std::isfinite(volume) || !std::isfinite(area)) {
    printNotices({"coordinates are too large to measure volume or area"});
  }
  if (options.json) {
    const bool moves = options.velocity.isNeeded(options.appearance);
    const slice::VelocityReport& velocity = sections->velocity;
    printJson({{"vertices", vertices},
               {"triangles", triangles},
               {"closed", closed},
               {"volume", volume},
               {"area", area},
               {"slabs_read", sections->slabsRead},
               {"slabs_skipped", sections->slabsSkipped},
               {"blocks_read", sections->blocksRead},
               {"bytes_read", input->reader->bytesRead()},
               {"requests", input->reader->requests()},
               {"light", sections->light},
               {"distance", sections->distance},
               {"volume_rate", velocityJson(moves, velocity.volumeRate)},
               {"max_speed", velocityJson(moves, velocity.maxSpeed)},
               {"clamped", velocityJson(moves, velocity.clamped)},
               {"velocity_of", velocityJson(moves, velocityOf(velocity))},
               {"color_range", painting->range()},
               {"quantization_error", quantizationError(encoding)},
               {"merge_distance", merged ? nlohmann::json(merged->distance) : nullptr}});
  } else {
    print("{}{}, {}, {}; volume {:.12g}, area {:.12g}\n",
          options.output.empty() ? "" : options.output + ": ",
          counted(vertices, "vertex", "vertices"), counted(triangles, "triangle"),
          closed ? "closed" : "NOT CLOSED", volume, area);
    const std::uint64_t requests = input->reader->requests();
    print("  read {} of {}, {}{}\n", sizeText(input->reader->bytesRead()),
          sizeText(input->reader->fileBytes()), counted(sections->slabsRead, "slab"),
          requests > 0 ? ", in " + counted(requests, "request") : "");
    if (options.light) print("  {}\n", detailText(sections->light, sections->distance));
    const slice::VelocityReport& velocity = sections->velocity;
    const std::string unit = velocityUnit(input->metadata, /*ofPlayback=*/false);
    printExtra({velocityText(options.velocity, velocity.maxSpeed, velocity.clamped, unit),
                options.velocity.velocity
                    ? fmt::format("the volume changes by {:.12g} per time unit; velocities are of "
                                  "the {}",
                                  velocity.volumeRate, velocityOf(velocity))
                    : "",
                merged ? fmt::format("coplanar triangles merged: {} before; no point moved further "
                                     "than {:.3g}",
                                     grouped(merged->before), merged->distance)
                       : "",
                painting->text(), quantizationText(encoding)});
  }
  if (triangles == 0)
    printNotices({"the slice is empty: the solid does not reach this hyperplane"});
  return reportLosses(losses, options.center);
}

}  // namespace

void addSlice(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("slice", "Cut a 4D mesh at a time or by another hyperplane");
  auto options = std::make_shared<SliceArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  auto* cuts = command->add_option_group("hyperplane", "Hyperplane (exactly one)");
  cuts->add_option("-t,--time", options->time, "Section at time V; coordinates (x, y, z)")
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
      ->add_option("-o,--output", options->output,
                   fmt::format("Output file: {} (default: none, only measure)",
                               formats::writableTriangleMeshExtensions()))
      ->check(someName())
      ->check(writableTriangleMesh());
  options->only.addTo(*command);
  command
      ->add_flag("--light", options->light,
                 "Interpolate the triangles of the layers: up to 13 times fewer, same volume")
      ->needs("--time");
  command
      ->add_option("--coplanar", options->coplanar,
                   "Keep coplanar triangles, or merge them into fewer")
      ->check(CLI::IsMember({"keep", "merge"}))
      ->capture_default_str();
  command->add_flag("--attributes", options->attributes,
                    "Write attributes; list those that the format cannot store (exit code 3)");
  options->appearance.addTo(*command);
  options->velocity.addTo(*command)->needs("--time");
  options->gltf.addTo(*command);
  addCenterOption(*command, options->center);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  t4d slice bolt.t4d --time 2.5 -o bolt-at-2.5.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
