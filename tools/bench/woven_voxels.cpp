#include "tools/bench/woven_voxels.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>

#include <fmt/format.h>

#include "model/parallel.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::bench {
namespace {

using Clock = std::chrono::steady_clock;

/// Passes frames on and knows how long they took to make.
class TimedFrames : public voxel4d::FrameSource {
 public:
  explicit TimedFrames(std::unique_ptr<FrameSource> frames) : frames_(std::move(frames)) {}
  const voxel4d::Lattice& lattice() const override { return frames_->lattice(); }
  std::size_t frameCount() const override { return frames_->frameCount(); }
  Result<voxel4d::Frame> frame(std::size_t index) override {
    const auto begin = Clock::now();
    auto frame = frames_->frame(index);
    seconds += std::chrono::duration<double>(Clock::now() - begin).count();
    return frame;
  }

  double seconds = 0;

 private:
  std::unique_ptr<FrameSource> frames_;
};

/// Makes every piece of a slab, as a writer does, and forgets it.
class Drain : public model::Sink {
 public:
  Result<void> put(const model::Slab& slab) override {
    bytes += slab.vertices.size() * sizeof(model::Point4) +
             slab.connectivity->cells.size() * sizeof(model::Cell);
    return {};
  }
  Result<void> putStreamed(const model::StreamedSlab& slab) override {
    eachPiece<model::Cell>(slab.cellCount,
                           [&](std::uint64_t first, auto into) { slab.cells(first, into); });
    // The lower layer has been made as the upper layer of the slab before.
    eachPiece<model::Point4>(
        slab.vertexCount - slab.lowerCount, [&](std::uint64_t first, auto into) {
          slab.vertices(slab.lowerCount + static_cast<std::uint32_t>(first), into);
        });
    return {};
  }

  std::uint64_t bytes = 0;

 private:
  template <class T, class Make>
  void eachPiece(std::uint64_t count, Make make) {
    constexpr std::uint64_t kPiece = 65536;
    model::forEach((count + kPiece - 1) / kPiece, [&](std::uint64_t i) {
      thread_local std::vector<T> piece(kPiece);
      model::isolate(
          [&] { make(i * kPiece, std::span(piece).first(std::min(kPiece, count - i * kPiece))); });
    });
    bytes += count * sizeof(T);
  }
};

struct Case {
  std::string name;
  voxel4d::FieldFunction field;
  model::Bounds3 box;
  std::size_t frames;
  voxel4d::SampleOptions options;
};

Case paperCube(std::size_t frames) {
  const auto field = [](const model::Point3& p, double t) {
    return (p - model::Point3(0, 0, t)).cwiseAbs().maxCoeff() - 10;
  };
  model::Bounds3 box;
  box.add({-54, -54, -22});
  box.add({73, 73, std::max(105.0, static_cast<double>(frames) + 20)});
  voxel4d::SampleOptions options;
  options.mask = true;
  options.slope = 1;
  return {fmt::format("the paper's cube, 128^3 x {}", frames), field, box, frames, options};
}

Case movingSphere() {
  const auto field = [](const model::Point3& p, double t) {
    return (p - model::Point3(31.3, 31.1, 22 + 0.5 * t)).norm() - 20;
  };
  model::Bounds3 box;
  box.add({0, 0, 0});
  box.add({63, 63, 63});
  voxel4d::SampleOptions options;
  options.slope = 1;
  options.asFloat = true;
  return {"a moving sphere, 64^3 x 32", field, box, 32, options};
}

Case largeShell() {
  const auto field = [](const model::Point3& p, double t) {
    return std::abs((p - model::Point3(0.3 + 0.5 * t, 0.1, 0.2)).norm() - 400) - 3;
  };
  model::Bounds3 box;
  box.add({-405, -405, -405});
  box.add({425, 405, 405});
  voxel4d::SampleOptions options;
  options.slope = 1;
  options.asFloat = true;
  return {"a moving shell of radius 400, 6 frames", field, box, 6, options};
}

/// The memory of the process from here on, as the system counts it; where it does, the peak starts
/// anew.
void forgetPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }

std::uint64_t peakSinceForgotten() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmHWM:", 0) == 0) return std::stoull(line.substr(6)) * 1024;
  }
  return peakBytes();
}

struct Measured {
  double seconds = 0;
  std::uint64_t bytes = 0;  // of vertices and cells
  std::uint64_t tetrahedra = 0;
  std::uint64_t peak = 0;
};

std::unique_ptr<voxel4d::FrameSource> framesOf(const Case& what) {
  std::vector<double> times;
  for (std::size_t i = 0; i < what.frames; ++i) times.push_back(static_cast<double>(i));
  return voxel4d::sampledFrames(what.field, {}, what.box, times, what.options);
}

Result<Measured> measure(const Case& what, int repetitions, std::size_t threads) {
  const model::ThreadLimit control(threads);
  Measured measured;
  std::vector<double> seconds;
  for (int i = 0; i < repetitions; ++i) {
    TimedFrames frames(framesOf(what));
    Drain drain;
    forgetPeak();
    const auto begin = Clock::now();
    const auto woven = voxel4d::weave(frames, {}, drain);
    if (!woven) return woven.error();
    seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count() - frames.seconds);
    measured.tetrahedra = woven->tetrahedra;
    measured.bytes = drain.bytes;
    measured.peak = std::max(measured.peak, peakSinceForgotten());
  }
  std::sort(seconds.begin(), seconds.end());
  measured.seconds = seconds[seconds.size() / 2];
  return measured;
}

struct Written {
  double seconds = 0;
  std::uint64_t bytes = 0;
  std::uint64_t peak = 0;
};

/// Weaves into a file, with the time that frames take left out.
Result<Written> measureWriting(const Case& what, const std::filesystem::path& folder) {
  formats::Metadata metadata;
  metadata.bodies = {{"woven"}};
  const auto path = folder / "woven.t4d";
  auto writer = formats::T4dWriter::create(path, metadata);
  if (!writer) return writer.error();
  TimedFrames frames(framesOf(what));
  forgetPeak();
  const auto begin = Clock::now();
  const auto woven = voxel4d::weave(frames, {}, writer->body(0));
  if (!woven) return woven.error();
  const auto bytes = writer->finish();
  if (!bytes) return bytes.error();
  Written written;
  written.seconds = std::chrono::duration<double>(Clock::now() - begin).count() - frames.seconds;
  written.bytes = *bytes;
  written.peak = peakSinceForgotten();
  std::filesystem::remove(path);
  return written;
}

/// The time that memcpy takes for so many bytes.
double secondsOfCopying(std::uint64_t bytes, int repetitions) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 28;
  const std::uint64_t part = std::min(bytes, kMost);
  std::vector<std::byte> from(part, std::byte{1});
  std::vector<std::byte> to(part, std::byte{2});
  const double seconds =
      medianSeconds(repetitions, [&] { std::memcpy(to.data(), from.data(), part); });
  return seconds * static_cast<double>(bytes) / static_cast<double>(part);
}

}  // namespace

Result<void> measureWovenVoxels(int repetitions, bool large, const std::filesystem::path& folder,
                                Report& report) {
  std::vector<std::pair<Case, int>> cases = {{paperCube(64), repetitions},
                                             {movingSphere(), repetitions}};
  if (large) cases.emplace_back(largeShell(), 1);
  for (const auto& [one, times] : cases) {
    double alone = 0;
    for (const std::size_t threads : {1U, 2U}) {
      const auto measured = measure(one, times, threads);
      if (!measured) return measured.error();
      const std::string name =
          fmt::format("voxel4d: {}, {} thread{}", one.name, threads, threads == 1 ? "" : "s");
      report.figures.push_back({name + ": cells", static_cast<double>(measured->tetrahedra), ""});
      report.figures.push_back({name + ": time", 1e3 * measured->seconds, "ms"});
      if (threads == 1) {
        alone = measured->seconds;
        report.rows.push_back({name, alone, "memcpy of what is put out",
                               secondsOfCopying(measured->bytes, repetitions)});
      } else {
        report.rows.push_back({one.name + ", 1 thread", alone, "2 threads", measured->seconds});
      }
      report.figures.push_back({name + ": cells a second",
                                static_cast<double>(measured->tetrahedra) / measured->seconds / 1e6,
                                "million"});
      report.figures.push_back(
          {name + ": peak memory", static_cast<double>(measured->peak) / 1e6, "MB"});
    }
  }
  for (const auto& [one, times] : cases) {
    const auto written = measureWriting(one, folder);
    if (!written) return written.error();
    const std::string name = "voxel4d: " + one.name + ", written";
    report.figures.push_back({name + ": time", 1e3 * written->seconds, "ms"});
    report.figures.push_back({name + ": size", static_cast<double>(written->bytes) / 1e6, "MB"});
    report.figures.push_back(
        {name + ": peak memory", static_cast<double>(written->peak) / 1e6, "MB"});
  }
  const auto few = measure(paperCube(64), repetitions, 1);
  const auto many = measure(paperCube(640), repetitions, 1);
  if (!few) return few.error();
  if (!many) return many.error();
  report.figures.push_back(
      {"voxel4d: ten times as many frames, time", many->seconds / few->seconds, "times"});
  report.figures.push_back({"voxel4d: ten times as many frames, peak memory",
                            static_cast<double>(many->peak) / static_cast<double>(few->peak),
                            "times"});
  return {};
}

}  // namespace t4d::bench
