#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "convert/first_looks.h"
#include "convert/flipbook.h"
#include "convert/frame_slices.h"
#include "convert/prism_steps.h"
#include "convert/shown_times.h"
#include "formats/gltf/gltf_morph_writer.h"
#include "formats/usd/usd_writer.h"
#include "model/progress.h"
#include "t4d/convert.h"

namespace t4d::convert {
namespace {

using model::Point3;
using model::Slab;

/// Adds the shapes of a body at the layers within a span of time, and at its ends.
class MorphSink : public PrismSteps {
 public:
  /// `seconds` after `span.begin` the span ends; of USD, time codes.
  MorphSink(const model::Body& body, const model::TimeSpan& span, double seconds,
            std::vector<std::pair<double, bool>> shown, const FlipbookOptions& options,
            formats::ShapesWriter& writer)
      : body_(body),
        span_(span),
        seconds_(seconds),
        shown_(std::move(shown)),
        options_(options),
        writer_(writer) {
    shape_.name = body.name;
  }

  double distance() const { return distance_; }
  std::uint64_t triangleCount() const { return shape_.mesh.triangles.size(); }
  const std::vector<std::string>& losses() const { return losses_; }

 private:
  Result<void> step(const Slab& slab) override {
    if (slab.timeEnd < span_.begin || slab.timeBegin > span_.end) return {};
    distance_ = std::max(distance_, slice::lightDistance(slab, triangles(), 0.25));
    if (!begun_) {
      begun_ = true;
      number(slab.lowerLayer().size());
      const double time = std::max(slab.timeBegin, span_.begin);
      place(slab, time);
      auto lost = addFirstLooks(body_, span_, options_, shape_);
      if (!lost) return lost.error();
      losses_ = std::move(*lost);
      if (auto done = writer_.addBody(shape_, secondsAt(time), shown_); !done) return done;
    }
    const double time = std::min(slab.timeEnd, span_.end);
    place(slab, time);
    return writer_.addShape(shape_, secondsAt(time));
  }

  double secondsAt(double time) const {
    const double length = span_.end - span_.begin;
    return length > 0 ? (time - span_.begin) / length * seconds_ : 0;
  }

  /// The vertices that triangles have, as in a light slice.
  void number(std::size_t lowerCount) {
    std::vector<std::uint32_t> numbers(lowerCount, 0);
    for (const model::Triangle& triangle : triangles()) {
      for (const std::uint32_t corner : triangle) numbers[corner] = 1;
    }
    for (std::uint32_t i = 0; i < lowerCount; ++i) {
      if (numbers[i] == 0) continue;
      numbers[i] = static_cast<std::uint32_t>(used_.size());
      used_.push_back(i);
    }
    for (const model::Triangle& triangle : triangles()) {
      shape_.mesh.triangles.push_back(
          {numbers[triangle[0]], numbers[triangle[1]], numbers[triangle[2]]});
    }
  }

  void place(const Slab& slab, double time) {
    const double fraction =
        time == slab.timeEnd ? 1 : (time - slab.timeBegin) / (slab.timeEnd - slab.timeBegin);
    shape_.mesh.vertices.clear();
    for (const std::uint32_t i : used_) {
      const Point3 from = slab.lowerLayer()[i].head<3>();
      const Point3 to = slab.upperLayer()[i].head<3>();
      shape_.mesh.vertices.emplace_back(fraction == 1 ? to : Point3(from + fraction * (to - from)));
    }
  }

  const model::Body& body_;
  formats::NamedMesh shape_;
  model::TimeSpan span_;
  double seconds_;
  std::vector<std::pair<double, bool>> shown_;
  const FlipbookOptions& options_;
  formats::ShapesWriter& writer_;
  std::vector<std::uint32_t> used_;
  std::vector<std::string> losses_;
  bool begun_ = false;
  double distance_ = 0;
};

Result<std::unique_ptr<formats::ShapesWriter>> shapesWriter(std::span<const model::Body> bodies,
                                                            const std::filesystem::path& path,
                                                            const FlipbookOptions& options) {
  const auto kept = [](auto writer) -> Result<std::unique_ptr<formats::ShapesWriter>> {
    using Writer = typename decltype(writer)::value_type;
    if (!writer) return writer.error();
    return std::make_unique<Writer>(std::move(*writer));
  };
  if (!formats::isUsd(path)) return kept(formats::MorphWriter::create(path, options.write));
  std::uint64_t layers = 0;
  for (const model::Body& body : bodies) layers += body.source->slabCount() + 1;
  return kept(formats::UsdWriter::create(path, options.framesPerSecond, layers, options.write));
}

}  // namespace

Result<FrameSlicesReport> writeMorphFlipbook(std::span<const model::Body> bodies,
                                             std::span<const double> times,
                                             const std::filesystem::path& path,
                                             const FlipbookOptions& options,
                                             const model::Progress& progress) {
  if (auto checked = checkFlipbook(bodies, times, options); !checked) {
    return checked.error();
  }
  const auto writer = shapesWriter(bodies, path, options);
  if (!writer) return writer.error();
  const model::TimeSpan span{times.front(), times.back()};
  const auto count = static_cast<double>(times.size());
  // Times in USD are counted in frames.
  const double perSecond = formats::isUsd(path) ? 1 : options.framesPerSecond;
  FrameSlicesReport report;
  report.frames = times.size();
  report.light = true;
  for (const model::Body& body : bodies) {
    auto shown = shownTimes(body, times, perSecond);
    if (shown.size() == 1 && !shown.front().second) continue;
    if (shown.size() == 1) shown.clear();
    MorphSink sink(body, span, (count - 1) / perSecond, std::move(shown), options, **writer);
    const auto number = static_cast<std::uint64_t>(&body - bodies.data());
    const model::Progress progressOfBody = model::eachOf(progress, number, bodies.size());
    if (auto done = model::pump(*body.source, sink, progressOfBody); !done) {
      return ofBody(body.name, "does not keep its triangles", done.error());
    }
    report.distance = std::max(report.distance, sink.distance());
    report.triangles += sink.triangleCount();
    addNewLines(sink.losses(), report.losses);
  }
  auto lost = (*writer)->finish(count / perSecond);
  if (!lost) return lost.error();
  addNewLines(*lost, report.losses);
  report.files = {path};
  return report;
}

}  // namespace t4d::convert
