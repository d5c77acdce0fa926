#include "tools/verbs/slice.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "convert/frame_slices.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "model/parallel.h"
#include "slice/merge_coplanar.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"
#include "tools/verbs/material_names.h"
#include "tools/verbs/members.h"
#include "tools/verbs/origin.h"
#include "tools/verbs/slice_writing.h"

namespace t4d::verbs {
namespace {

using nlohmann::ordered_json;

using Sections = std::vector<formats::NamedMesh>;

slice::Hyperplane hyperplaneOf(const SliceOptions& options) {
  return options.time ? slice::Hyperplane::atTime(*options.time) : options.hyperplane;
}

Result<void> checkSliceOptions(const SliceOptions& options) {
  if (auto good = slice::checkHyperplane(hyperplaneOf(options)); !good) {
    return fail(ErrorCode::Options, good.error().message);
  }
  const SliceWriteOptions& write = options.write;
  if (!options.time &&
      (write.color == "time" || write.color == "speed" || write.isColoredByTrack())) {
    return fail(ErrorCode::Options,
                "colours by time, speed or track are those of a slice at a time");
  }
  if (options.light && write.isColoredByTrack()) {
    return fail(ErrorCode::Options, "colours by track are those of exact slices");
  }
  if (!options.time && (options.light || write.velocity)) {
    return fail(ErrorCode::Options, "light slices and velocities are those of a slice at a time");
  }
  return checkSliceWriteOptions(write, options.output);
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
  if (auto good = checkSliceOptions(options); !good) return good.error();
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

}  // namespace t4d::verbs
