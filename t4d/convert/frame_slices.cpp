#include "t4d/convert/frame_slices.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "t4d/model/in_order.h"

namespace t4d::convert {
namespace {

struct Frame {
  std::vector<formats::NamedMesh> meshes;
  bool light = true;
  double distance = 0;
  std::vector<std::pair<std::string, std::string>> exact;  // bodies with exact slices, and why
  std::vector<std::string> losses;
};

/// Slices of one body, of either kind.
class BodySlicer {
 public:
  BodySlicer(const model::Body& body, slice::SliceDetail detail)
      : body_(body), detail_(detail), exact_(*body.source), light_(*body.source) {}

  /// Adds what there is at a time.
  Result<void> add(double time, Frame& frame) const {
    if (!model::timeWithin(*body_.source, time)) return {};
    if (detail_ == slice::SliceDetail::Exact) {
      auto slice = exact_.at(time);
      if (!slice) return pass(slice.error());
      frame.light = false;
      add(std::move(*slice), /*light=*/false, frame);
      return {};
    }
    auto slice = light_.at(time);
    if (!slice) return pass(slice.error());
    frame.light = frame.light && slice->light;
    frame.distance = std::max(frame.distance, slice->distance);
    if (!slice->light) frame.exact.emplace_back(body_.name, slice->whyExact);
    add(std::move(slice->slice), slice->light, frame);
    return {};
  }

 private:
  void add(slice::Slice slice, bool light, Frame& frame) const {
    frame.meshes.push_back(
        {.name = body_.name, .mesh = std::move(slice.mesh), .ownCorners = light});
    for (std::string& loss : slice.losses) frame.losses.push_back(std::move(loss));
  }

  const model::Body& body_;
  slice::SliceDetail detail_;
  slice::TimeSlicer exact_;
  slice::LightSlicer light_;
};

void addNew(const std::vector<std::string>& lines, std::vector<std::string>& to) {
  for (const std::string& line : lines) {
    if (std::ranges::find(to, line) == to.end()) to.push_back(line);
  }
}

}  // namespace

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
                                       std::span<const double> times, slice::SliceDetail detail,
                                       const UseFrame& take, const Paint& paint,
                                       const model::Progress& progress, const UseFrame& prepare) {
  if (auto checked = checkFrameTimes(bodies, times); !checked) return pass(checked.error());
  std::vector<std::unique_ptr<BodySlicer>> slicers;
  for (const model::Body& body : bodies) {
    slicers.push_back(std::make_unique<BodySlicer>(body, detail));
  }
  using FramePointer = std::shared_ptr<Result<Frame>>;
  const auto frameAt = [&](std::size_t number) -> FramePointer {
    Frame frame;
    for (const auto& slicer : slicers) {
      if (auto added = slicer->add(times[number], frame); !added) {
        return std::make_shared<Result<Frame>>(pass(added.error()));
      }
    }
    for (formats::NamedMesh& mesh : frame.meshes) {
      if (paint) paint(mesh, times[number]);
    }
    if (prepare) {
      if (auto prepared = prepare(number, frame.meshes); !prepared) {
        return std::make_shared<Result<Frame>>(pass(prepared.error()));
      }
    }
    return std::make_shared<Result<Frame>>(std::move(frame));
  };
  FrameSlicesReport report;
  report.light = detail == slice::SliceDetail::Light;
  Result<void> done;
  std::set<std::string> noted;  // of each body, the first slab is named
  model::inOrder<FramePointer>(times.size(), frameAt, [&](const FramePointer& made) {
    if (!*made) {
      done = pass(made->error());
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
    for (const auto& [body, why] : frame.exact) {
      if (!noted.insert(body).second) continue;
      report.notices.push_back(fmt::format(
          "body '{}' has exact slices, because a slab does not consist of prisms: {}", body, why));
    }
    addNew(frame.losses, report.losses);
    ++report.frames;
    if (progress) progress(static_cast<double>(report.frames) / static_cast<double>(times.size()));
    return true;
  });
  if (!done) return pass(done.error());
  return report;
}

}  // namespace t4d::convert
