#include "t4d/weave.h"

#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "model/limits.h"
#include "model/parallel.h"
#include "model/progress.h"
#include "platform/freed_memory.h"
#include "t4d/mesh.h"
#include "voxel4d/frame_layer.h"
#include "voxel4d/frame_parts.h"
#include "voxel4d/graded_cap.h"
#include "voxel4d/woven_slab.h"

namespace t4d::voxel4d {
namespace {

/// Puts the slabs of a mesh into the sink and counts them.
class SlabWriter {
 public:
  /// `metric` may be null (WovenSlab::between).
  SlabWriter(const Lattice& lattice, const FaceMetric* metric, model::Sink& sink)
      : lattice_(lattice), metric_(metric), sink_(sink) {}

  Result<void> put(const FrameLayer& before, const FrameLayer& after, const model::TimeSpan& time,
                   const model::TimeSpan& crossings) {
    const bool takesTime = crossings.begin < crossings.end;  // that of a cap does not
    auto slab =
        WovenSlab::between(before, after, time, crossings, lattice_, takesTime ? metric_ : nullptr);
    if (!slab) return slab.error();
    count((*slab)->vertexCount - (*slab)->lowerCount, (*slab)->cellCount);
    if (auto put = sink_.putStreamed(**slab); !put) return put;
    slab->reset();
    constexpr std::uint64_t kManyCells = std::uint64_t{1} << 22U;
    if (lastTetrahedra > kManyCells) platform::giveBackFreedMemory();
    if (auto read = before.checkRead(); !read) return read;
    return after.checkRead();
  }

  Result<void> putGraded(const FrameLayer& layer, CapEnd end) {
    const auto slab = gradedCap(layer, lattice_, end);
    if (!slab) return slab.error();
    if (auto read = layer.checkRead(); !read) return read;
    const model::Connectivity& connectivity = *slab->connectivity;
    count(connectivity.vertexCount - connectivity.lowerCount, connectivity.cells.size());
    return sink_.put(*slab);
  }

  WeaveReport report;
  std::uint64_t lastTetrahedra = 0;  // of the last slab

 private:
  void count(std::uint64_t vertices, std::uint64_t tetrahedra) {
    report.vertices += vertices;
    report.tetrahedra += tetrahedra;
    lastTetrahedra = tetrahedra;
  }

  const Lattice& lattice_;
  const FaceMetric* metric_;
  model::Sink& sink_;
};

/// A slab that is put while the next frame is read, if there is a thread for it.
class PutAside {
 public:
  PutAside() = default;
  PutAside(const PutAside&) = delete;
  PutAside& operator=(const PutAside&) = delete;
  ~PutAside() noexcept { work_.wait(); }

  template <class Put>
  void begin(const Put& put) {
    work_.begin([this, put] { done_ = put(); });
  }
  Result<void> wait() {
    work_.wait();
    return std::exchange(done_, {});
  }

 private:
  Result<void> done_;
  model::Aside work_;
};

/// Whether a slab before which stands one of so many cells, and whose frames take so much memory,
/// is put aside. Large slabs occupy all threads, and the frame that is read meanwhile is a third in
/// memory.
bool mayBeAside(std::uint64_t cellsBefore, const FrameLayer& layer, std::size_t largeFrame) {
  return model::threadCount() > 1 && cellsBefore <= model::kCellsAtOnce &&
         layer.storedBlocks() < largeFrame / sizeof(ValueBuffer);
}

}  // namespace

Result<WeaveReport> weave(FrameSource& frames, const WeaveOptions& options, model::Sink& into,
                          const model::Progress& progress) {
  const std::size_t count = frames.frameCount();
  if (count < 2) {
    return invalid(fmt::format("a motion has at least two frames, this one {}", count));
  }
  const model::Part& part = options.part;
  const bool isWhole = part.isFirst() && part.isLast();
  if (count - 1 < part.count) {
    return invalid(fmt::format("the {} frames have {} step{} between them, too few for {} parts",
                               count, count - 1, count == 2 ? "" : "s", part.count));
  }
  const model::PartRange steps = part.of(count - 1);
  if (!isWhole) frames.readsPart();
  const Lattice lattice = frames.lattice();
  model::Affine3x4 place = lattice.place();
  std::optional<model::Transformed> placed;
  if (options.toSpace) {
    place.col(3) = *options.toSpace * place.col(3).homogeneous();
    place.leftCols<3>() = options.toSpace->leftCols<3>() * place.leftCols<3>();
    placed.emplace(into, model::Transform{*options.toSpace});
  }
  model::Sink& sink = placed ? *placed : into;
  std::optional<FaceMetric> metric;
  if (options.between == Between::Distance) {
    const Eigen::RowVector3d edges = place.leftCols<3>().colwise().norm();
    metric.emplace(std::array{edges[0], edges[1], edges[2]});
  }
  SlabWriter slabs(lattice, metric ? &*metric : nullptr, sink);
  const bool graded = options.caps == CapStyle::Graded;
  const bool half = options.caps == CapStyle::HalfStep;
  const FrameLayer nothing;
  const auto putFirstCap = [&](const FrameLayer& first, double time) -> Result<void> {
    auto put = graded ? slabs.putGraded(first, CapEnd::First)
                      : slabs.put(nothing, first, {time, first.time()}, {time, time});
    slabs.report.capTetrahedra[0] = slabs.lastTetrahedra;
    return put;
  };
  const auto layerOf = [&](std::size_t i) -> Result<FrameLayer> {
    auto frame = frames.frame(i);
    if (!frame) return frame.error();
    auto checked = checkFrame(*frame);
    if (checked) checked = checkPlace(*frame, place);
    if (!checked) return invalid(checked.error().message, frames.placeOf(i));
    if (!(std::abs(frame->time) <= model::kLargestCoordinate)) {
      return invalid(fmt::format("is at time {}; the largest possible is {}", frame->time,
                                 model::kLargestCoordinate),
                     frames.placeOf(i));
    }
    auto layer = FrameLayer::of(std::move(*frame), lattice, options.largeFrame);
    if (!layer) layer.error().where = frames.placeOf(i);
    return layer;
  };
  // Frame i is at i % 3: the two before it may be in use when it comes.
  std::array<FrameLayer, 3> layers;
  FrameParts partsBefore;
  double halfStepAfter = 0;
  PutAside putting;
  for (std::size_t i = steps.begin; i <= steps.end; ++i) {
    const bool isFirst = i == steps.begin;
    auto layer = layerOf(i);
    if (auto put = putting.wait(); !put) return put.error();
    if (!layer) return layer.error();
    layers[(i + 1) % 3] = {};
    const FrameLayer& before = layers[(i + 2) % 3];
    const FrameLayer& after = layers[i % 3] = std::move(*layer);
    const double begin = before.time();
    const double end = after.time();
    if (!isFirst && !(end > begin)) {
      return invalid(fmt::format("is at time {}, not after frame {}, at {}", end, i - 1, begin),
                     frames.placeOf(i));
    }
    if (!isFirst && end - begin < model::kSmallestExtent) {
      return invalid(fmt::format("is {} after the frame before it; at least {} is possible",
                                 end - begin, model::kSmallestExtent),
                     frames.placeOf(i));
    }
    // A cap of half a step waits for the second frame, which says how long a step is.
    if (half && !isFirst && i == 1) {
      const double first = model::dividedTime({end, begin}, 3, 2);
      if (auto put = putFirstCap(before, first); !put) return put.error();
    } else if (!half && i == 0) {
      if (auto put = putFirstCap(after, end); !put) return put.error();
    }
    FrameParts partsAfter(after.frame());
    if (!isFirst) {
      addPartsLost(before.frame(), partsBefore, after.frame(), partsAfter, i - 1, place,
                   slabs.report.partsLost);
      halfStepAfter = model::dividedTime({begin, end}, 3, 2);
      const auto put = [&slabs, &before, &after, begin, end] {
        return slabs.put(before, after, {begin, end}, {begin, end});
      };
      if (mayBeAside(slabs.lastTetrahedra, after, options.largeFrame)) {
        putting.begin(put);
      } else {
        if (auto done = put(); !done) return done.error();
        layers[(i + 2) % 3] = {};
      }
    }
    slabs.report.masks += after.isMask() ? 1 : 0;
    partsBefore = std::move(partsAfter);
    ++slabs.report.frames;
    const auto on = model::report(progress, slabs.report.frames, steps.size() + 1);
    if (!on) return on.error();
  }
  if (auto put = putting.wait(); !put) return put.error();
  if (!part.isLast()) return slabs.report;
  const FrameLayer& before = layers[steps.end % 3];
  const double end = before.time();
  const double last = half ? halfStepAfter : end;
  if (auto put = graded ? slabs.putGraded(before, CapEnd::Last)
                        : slabs.put(before, nothing, {end, last}, {last, last});
      !put) {
    return put.error();
  }
  slabs.report.capTetrahedra[1] = slabs.lastTetrahedra;
  if (isWhole && slabs.report.tetrahedra == 0) {
    return invalid("no frame has a surface: nothing is inside at any time");
  }
  return slabs.report;
}

}  // namespace t4d::voxel4d
