#include "tools/t4d/painting.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "convert/attribute_colors.h"
#include "convert/frame_slices.h"
#include "slice/velocity.h"
#include "t4d/mesh.h"
#include "tools/t4d/slice_tracks.h"

namespace t4d::tools {
namespace {

using formats::Color;

/// 0xrrggbb in sRGB.
Color linearColor(std::uint32_t sRgb) {
  Color color = {0, 0, 0, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = static_cast<double>(sRgb >> (16 - 8 * i) & 0xff) / 255;
    color[i] = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  }
  return color;
}

/// Well apart, also for the colour-blind (Okabe and Ito).
constexpr std::array<std::uint32_t, 7> kBodyPalette = {0xe69f00, 0x56b4e9, 0x009e73, 0xf0e442,
                                                       0x0072b2, 0xd55e00, 0xcc79a7};

convert::Paint bodyPaint(const formats::Metadata& metadata) {
  std::map<std::string, Color> colors;
  for (std::size_t i = 0; i < metadata.bodies.size(); ++i) {
    const formats::BodyInfo& body = metadata.bodies[i];
    Color own = linearColor(kBodyPalette[i % kBodyPalette.size()]);
    if (!body.color.empty()) {
      own[3] = 1;
      std::copy_n(body.color.begin(), std::min(body.color.size(), own.size()), own.begin());
    }
    colors[body.name] = own;
  }
  return [colors](formats::NamedMesh& mesh, double) {
    const auto found = colors.find(mesh.name);
    if (found != colors.end()) mesh.color = found->second;
  };
}

convert::Paint timePaint(const model::TimeSpan& span) {
  return [span](formats::NamedMesh& mesh, double time) {
    const double length = span.end - span.begin;
    mesh.color = convert::rampColor(length > 0 ? (time - span.begin) / length : 0);
  };
}

Painting attributePainting(convert::AttributeColors colors) {
  Painting painting;
  if (!colors.distinct && (colors.components == 1 || colors.magnitude)) {
    painting.range = {colors.low, colors.high};
  }
  const auto shared = std::make_shared<const convert::AttributeColors>(std::move(colors));
  painting.paint = [shared](formats::NamedMesh& mesh, double) { shared->paint(mesh); };
  return painting;
}

template <class Element>
Result<Painting> paintingOfElements(const SliceWriteOptions& options, const Input& input,
                                    std::span<const Element> elements) {
  if (options.color == "body") return Painting{bodyPaint(input.metadata)};
  if (options.color == "time") return Painting{timePaint(model::timeSpanOf(input.bodies))};
  if (!options.isColoredByAttribute()) return Painting();
  const bool distinct = options.color == "triangle";
  auto colors = convert::attributeColors(
      distinct ? options.color : options.color.substr(kColorByAttribute.size()), distinct,
      elements);
  if (!colors) return colors.error();
  return attributePainting(std::move(*colors));
}

}  // namespace

Painting paintingBySpeed(double largest) {
  return attributePainting({.attribute = std::string(slice::kVelocity),
                            .components = 3,
                            .magnitude = true,
                            .high = largest});
}

Result<Painting> paintingByTrack(const Input& input, std::span<const double> times,
                                 Observer& observer) {
  measure::TrackOptions tracking;
  tracking.times.assign(times.begin(), times.end());
  tracking.layers = false;
  const auto report = track(input, tracking, observer);
  if (!report) return report.error();
  const auto tracks = std::make_shared<const SliceTracks>(*report);
  return Painting{[tracks](formats::NamedMesh& mesh, double time) {
    const std::vector<std::uint64_t> ids = tracks->of(mesh.name, mesh.mesh, time);
    formats::MeshColors colors{model::Domain::Cell, {}};
    std::vector<std::uint32_t> values;
    for (const std::uint64_t id : ids) {
      const Color color = trackColor(id);
      colors.colors.push_back({static_cast<float>(color[0]), static_cast<float>(color[1]),
                               static_cast<float>(color[2]), static_cast<float>(color[3])});
      values.push_back(static_cast<std::uint32_t>(id));
    }
    std::erase_if(mesh.mesh.attributes,
                  [](const model::Attribute& attribute) { return attribute.name == kTrack; });
    mesh.mesh.attributes.push_back(
        model::makeAttribute(std::string(kTrack), model::Domain::Cell, values));
    mesh.colors = std::move(colors);
  }};
}

Result<Painting> paintingOf(const SliceWriteOptions& options, const Input& input) {
  return paintingOfElements(options, input, std::span<const model::Body>(input.bodies));
}

Result<Painting> paintingOf(const SliceWriteOptions& options, const Input& input,
                            std::span<const formats::NamedMesh> meshes) {
  return paintingOfElements(options, input, meshes);
}

Result<Painting> paintingOfFrames(const SliceWriteOptions& options, const Input& input,
                                  std::span<const double> times, slice::SliceDetail detail,
                                  const std::optional<convert::FrameVelocity>& velocity,
                                  Observer& observer) {
  if (options.isColoredByTrack()) return paintingByTrack(input, times, observer);
  if (!options.isColoredBySpeed()) return paintingOf(options, input);
  const auto stage = observer.stage("looking for the largest speed", times.size(), "frames");
  const auto nothing = [](std::size_t, std::span<const formats::NamedMesh>) {
    return Result<void>();
  };
  const auto found = convert::forEachFrame(input.bodies, times, {detail, velocity, {}, false},
                                           nothing, stage->callback());
  if (!found) return found.error();
  return paintingBySpeed(found->maxSpeed);
}

}  // namespace t4d::tools
