#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "tools/verbs/envelope.h"
#include "tools/verbs/json_text.h"

namespace t4d::verbs {
namespace {

/// Numbers of all these passages together.
nlohmann::ordered_json envelopeNumbers(std::span<const Passage> all, const EnvelopeReport& report) {
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
  double voxelSize = 0;
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
  return {
      {"vertices", vertices},
      {"triangles", triangles},
      {"closed", closed},
      {"self_intersections", orNull(crossings)},
      {"components", components},
      {"cavities", cavities},
      {"genus", std::llround(genus)},
      {"volume", volume},
      {"visits_volume", visitsVolume},
      {"hypervolume", hypervolume},
      {"hypervolume_by_flux", byFlux},
      {"voxel_size", voxelSize > 0 ? nlohmann::ordered_json(voxelSize) : nlohmann::ordered_json()},
      {"error_bound", errorBound},
      {"chord_bound", orNull(chords)},
      {"outside", report.options.contains()},
      {"inflate", orNull(report.options.inflate)},
      {"simplify", orNull(report.options.simplify)},
      {"outside_by", orNull(outside)},
      {"silhouette_triangles", silhouette}};
}

}  // namespace

std::string jsonOf(const EnvelopeReport& report, std::uint64_t peakBytes) {
  const Passages& passages = report.passages;
  nlohmann::ordered_json value = envelopeNumbers(passages.all, report);
  value["bodies"] = nlohmann::ordered_json::array();
  if (report.options.part) {
    for (const char* name : {"vertices", "triangles", "closed", "self_intersections", "components",
                             "cavities", "genus", "volume", "error_bound"}) {
      value[name] = nullptr;
    }
    value["voxel_size"] = report.fieldVoxelSize;
  } else {
    for (const Passage& one : passages.all) {
      nlohmann::ordered_json body = {
          {"name", one.name},
          {"file", one.file.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(one.file)}};
      body.update(envelopeNumbers({&one, 1}, report));
      value["bodies"].push_back(std::move(body));
    }
  }
  value["fields"] = nlohmann::ordered_json::array();
  for (const auto& [name, file, bytes] : report.fields) {
    value["fields"].push_back({{"name", name}, {"file", file}, {"bytes", bytes}});
  }
  value["time_begin"] = passages.span.begin;
  value["time_end"] = passages.span.end;
  value["seconds"] = report.seconds;
  value["peak_bytes"] = peakBytes;
  return jsonText(value);
}

}  // namespace t4d::verbs
