#include "convert/frame_slices.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "model/parallel.h"
#include "model/progress.h"
#include "slice/velocity.h"
#include "t4d/convert.h"

namespace t4d::convert {
namespace {

struct Frame {
  std::vector<formats::NamedMesh> meshes;
  bool light = true;
  double distance = 0;
  double maxSpeed = 0;
  std::uint64_t clamped = 0;
  std::vector<std::pair<std::string, std::string>> exact;  // bodies with exact slices, and why
  std::vector<std::string> losses;
};

/// Slices of one body, of either kind.
class BodySlicer {
 public:
  BodySlicer(const model::Body& body, const FrameSlicing& slicing)
      : body_(body),
        slicing_(slicing),
        exact_(*body.source, motionOf(slicing)),
        light_(*body.source, motionOf(slicing)) {}

  /// Adds what there is at the time of a frame, by its number.
  Result<void> add(std::size_t number, double time, Frame& frame) const {
    if (!model::timeWithin(*body_.source, time)) return {};
    if (slicing_.detail == slice::SliceDetail::Exact) {
      auto slice = exact_.at(time);
      if (!slice) return slice.error();
      frame.light = false;
      return add(number, std::move(*slice), /*light=*/false, frame);
    }
    auto slice = light_.at(time);
    if (!slice) return slice.error();
    frame.light = frame.light && slice->light;
    frame.distance = std::max(frame.distance, slice->distance);
    if (!slice->light) frame.exact.emplace_back(body_.name, slice->whyExact);
    return add(number, std::move(slice->slice), slice->light, frame);
  }

 private:
  static slice::WithMotion motionOf(const FrameSlicing& slicing) {
    return slicing.velocity ? slice::WithMotion::Yes : slice::WithMotion::No;
  }

  Result<void> add(std::size_t number, slice::Slice slice, bool light, Frame& frame) const {
    if (const auto& velocity = slicing_.velocity) {
      const std::vector<double>& units = velocity->timeUnits;
      auto added = addVelocity(slice, {velocity->most, units.empty() ? 1 : units[number]});
      if (!added) return added.error();
      frame.maxSpeed = std::max(frame.maxSpeed, added->maxSpeed);
      frame.clamped += added->clamped;
    }
    frame.meshes.push_back(
        {.name = body_.name, .mesh = std::move(slice.mesh), .ownCorners = light});
    for (std::string& loss : slice.losses) frame.losses.push_back(std::move(loss));
    return {};
  }

  const model::Body& body_;
  const FrameSlicing& slicing_;
  slice::TimeSlicer exact_;
  slice::LightSlicer light_;
};

}  // namespace

void addNewLines(std::span<const std::string> lines, std::vector<std::string>& to) {
  for (const std::string& line : lines) {
    if (std::ranges::find(to, line) == to.end()) to.push_back(line);
  }
}

void dropAttributes(const FrameSlicing& slicing, model::TriangleMesh& mesh) {
  if (!slicing.velocity) return;
  std::erase_if(mesh.attributes, [&](const model::Attribute& attribute) {
    return attribute.name == slice::kVelocity ? !slicing.velocity->write : !slicing.attributes;
  });
}

std::vector<double> playbackRates(std::span<const double> times, double framesPerSecond) {
  std::vector<double> rates;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1;
    const std::size_t after = std::min(i + 1, times.size() - 1);
    rates.push_back((times[after] - times[before]) * framesPerSecond /
                    static_cast<double>(after - before));
  }
  return rates;
}

Result<void> checkFrameTimes(std::span<const model::Body> bodies, std::span<const double> times) {
  if (std::ranges::all_of(bodies,
                          [](const model::Body& body) { return body.source->slabCount() == 0; })) {
    return invalid("there is nothing to show: no body has a slab");
  }
  if (times.empty()) return invalid("there are no times to show the mesh at");
  const model::TimeSpan span = model::timeSpanOf(bodies);
  for (const double time : times) {
    if (!model::timeWithin(span, time)) {
      return invalid(fmt::format("time {} is outside the mesh, which lasts from {} to {}", time,
                                 span.begin, span.end));
    }
  }
  return {};
}

Result<FrameSlicesReport> forEachFrame(std::span<const model::Body> bodies,
                                       std::span<const double> times, const FrameSlicing& slicing,
                                       const UseFrame& take, const model::Progress& progress,
                                       const UseFrame& prepare) {
  if (auto checked = checkFrameTimes(bodies, times); !checked) return checked.error();
  std::vector<std::unique_ptr<BodySlicer>> slicers;
  for (const model::Body& body : bodies) {
    slicers.push_back(std::make_unique<BodySlicer>(body, slicing));
  }
  using FramePointer = std::shared_ptr<Result<Frame>>;
  const auto frameAt = [&](std::size_t number) -> FramePointer {
    Frame frame;
    for (const auto& slicer : slicers) {
      if (auto added = slicer->add(number, times[number], frame); !added) {
        return std::make_shared<Result<Frame>>(added.error());
      }
    }
    for (formats::NamedMesh& mesh : frame.meshes) {
      if (slicing.paint) slicing.paint(mesh, times[number]);
      dropAttributes(slicing, mesh.mesh);
    }
    if (prepare) {
      if (auto prepared = prepare(number, frame.meshes); !prepared) {
        return std::make_shared<Result<Frame>>(prepared.error());
      }
    }
    return std::make_shared<Result<Frame>>(std::move(frame));
  };
  FrameSlicesReport report;
  report.light = slicing.detail == slice::SliceDetail::Light;
  Result<void> done;
  std::set<std::string> noted;  // of each body, the first slab is named
  model::inOrder<FramePointer>(times.size(), frameAt, [&](const FramePointer& made) {
    if (!*made) {
      done = made->error();
      return false;
    }
    Frame& frame = **made;
    done = take(report.frames, frame.meshes);
    if (!done) return false;
    for (const formats::NamedMesh& mesh : frame.meshes) {
      report.triangles += mesh.mesh.triangles.size();
    }
    report.light = report.light && frame.light;
    report.distance = std::max(report.distance, frame.distance);
    report.maxSpeed = std::max(report.maxSpeed, frame.maxSpeed);
    report.clamped += frame.clamped;
    for (const auto& [body, why] : frame.exact) {
      if (!noted.insert(body).second) continue;
      report.notices.push_back(fmt::format(
          "body '{}' has exact slices, because a slab does not consist of prisms: {}", body, why));
    }
    addNewLines(frame.losses, report.losses);
    ++report.frames;
    done = model::report(progress, report.frames, times.size());
    return done.has_value();
  });
  if (!done) return done.error();
  return report;
}

}  // namespace t4d::convert
