#include <algorithm>
#include <cmath>

#include "tools/t4d/envelope.h"
#include "tools/t4d/members.h"

namespace t4d::tools {
namespace {

/// Adds the numbers of these passages together; those of the envelope are null for a part of the
/// `whole` report.
void addPassageNumbers(Members& members, bool whole, std::span<const Passage> all,
                       const EnvelopeReport& report) {
  const bool isPart = report.options.part.has_value();
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t silhouette = 0;
  std::uint64_t components = 0;
  std::uint64_t cavities = 0;
  double genus = 0;
  double volume = 0;
  double visitsVolume = 0;
  double hypervolume = 0;
  double byFlux = 0;
  double voxelSize = isPart ? report.fieldVoxelSize : 0;
  double errorBound = 0;
  bool closed = true;
  std::optional<std::uint64_t> crossings = 0;
  std::optional<double> chords = 0;
  std::optional<double> outside = 0;
  for (const Passage& one : all) {
    const measure::Silhouette& passed = one.silhouette;
    const edit::Envelope& envelope = one.envelope;
    vertices += envelope.mesh.vertices.size();
    triangles += envelope.mesh.triangles.size();
    silhouette += passed.surface.triangles.size();
    closed = closed && model::isClosed(envelope.mesh);
    components += envelope.components;
    cavities += envelope.cavities;
    genus += envelope.genus;
    volume += envelope.volume;
    visitsVolume += passed.visitsVolume;
    hypervolume += passed.hypervolume;
    byFlux += passed.hypervolumeByFlux;
    voxelSize = std::max(voxelSize, envelope.voxelSize);
    errorBound = std::max(errorBound, envelope.errorBound);
    if (!envelope.selfIntersections) crossings.reset();
    chords = chords && one.chordBound ? std::max(chords, one.chordBound) : std::nullopt;
    outside = outside && one.outsideBy() ? std::max(outside, one.outsideBy()) : std::nullopt;
  }
  if (!report.options.contains()) outside.reset();
  if (isPart) crossings.reset();
  const auto addOfEnvelope = [&](const char* name, auto value, const char* meaning) {
    Member member = members(name, value, meaning);
    if (whole) member.nullIf(isPart);
    return member;
  };
  addOfEnvelope("vertices", vertices, "Vertices of the envelope; null with --part.");
  addOfEnvelope("triangles", triangles, "Triangles of the envelope; null with --part.");
  addOfEnvelope("closed", closed, "Whether every edge has two triangles; null with --part.");
  members("self_intersections", crossings,
          "Pairs of triangles that cross; null in a build without CGAL, which does not look for "
          "them, and with --part.");
  addOfEnvelope("components", components, "Connected parts of the solid; null with --part.");
  addOfEnvelope("cavities", cavities, "Closed surfaces within them; null with --part.");
  addOfEnvelope(
      "genus", std::llround(genus),
      "The sum of those of all connected surfaces: how many holes go through; null with --part.");
  addOfEnvelope("volume", volume, "Enclosed by the envelope, in length^3; null with --part.");
  members("visits_volume", visitsVolume,
          "The integral of the number of visits, in length^3; exact for the 4D mesh.");
  members("hypervolume", hypervolume,
          "The integral of the time that places are covered, in length^3 * time; exact for the 4D "
          "mesh.");
  members("hypervolume_by_flux", byFlux, "The same, computed as validate does.");
  members("voxel_size", voxelSize > 0 ? std::optional(voxelSize) : std::nullopt,
          "The spacing of the lattice; null with --exact. The largest, if bodies differ.")
      .above(0);
  addOfEnvelope(
      "error_bound", errorBound,
      "Every place that is farther than this from the true boundary is on its true side, in "
      "length units; null with --part.")
      .atLeast(0);
  members(
      "chord_bound", chords,
      "How far the 4D mesh can be from the motion that it was swept from, in length units; null "
      "if unknown, and with --part.")
      .atLeast(0);
  members("outside", report.options.contains(),
          "Whether the envelope contains the motion for certain (--outside); the 4D mesh, if "
          "chord_bound is null.");
  members(
      "inflate", report.options.inflate,
      "The distance of --inflate, in length units: everything within it of the motion is in the "
      "envelope, too. null without it.")
      .atLeast(0);
  members("simplify", report.options.simplify,
          "The largest number of triangles of --simplify; null without it.")
      .atLeast(4);
  members(
      "outside_by", outside,
      "No place of an envelope made with --outside, and no point of the surface of one made with "
      "--simplify, is farther than this from the motion, in length units; null without them, and "
      "if chord_bound is null.")
      .atLeast(0);
  members("silhouette_triangles", silhouette,
          "Triangles of the silhouette, from which the envelope is made.");
}

}  // namespace

void describe(Members& members, const EnvelopeReport& report) {
  const Passages& passages = report.passages;
  addPassageNumbers(members, true, passages.all, report);
  const std::span<const Passage> all = passages.all;
  members("bodies", report.options.part ? all.first(0) : all,
          "With --each one for each body, otherwise one for all; none with --part.",
          [&](Members& own, const Passage& one) {
            own("name", one.name, "Of the body, or envelope for several together.");
            own("file", one.file.empty() ? std::nullopt : std::optional(one.file),
                "The file that it was written to: one for all, or one per body if {body} is in the "
                "name of the output; null without -o.");
            addPassageNumbers(own, false, {&one, 1}, report);
          });
  members("fields", report.fields, "The fields that were written; with --part their parts.",
          [](Members& own, const WrittenField& field) {
            own("name", field.name, "Which field.").oneOf({"visits", "dwell", "first", "last"});
            own("file", field.file, "The file.");
            own("bytes", field.bytes, "Its size.");
          });
  members("time_begin", passages.span.begin, "The first time that counts.");
  members("time_end", passages.span.end, "The last time that counts.");
  addCosts(members, report.seconds);
}

}  // namespace t4d::tools
