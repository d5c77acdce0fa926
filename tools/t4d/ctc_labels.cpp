#include "tools/t4d/ctc_labels.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "convert/frame_files.h"
#include "convert/frame_slices.h"
#include "formats/output_folder.h"
#include "formats/tiff_writer.h"
#include "measure/visit_lattice.h"
#include "platform/replaceable.h"
#include "t4d/mesh.h"
#include "tools/t4d/slice_tracks.h"

namespace t4d::tools {
namespace {

namespace fs = std::filesystem;
using model::Point3;
using Size = std::array<std::uint32_t, 3>;

constexpr std::uint64_t kMostLabels = std::numeric_limits<std::uint16_t>::max();
constexpr std::uint64_t kMostPoints = std::uint64_t{1} << 31;
constexpr const char* kTracksFile = "res_track.txt";

std::string nameOfFrame(std::size_t frame, std::size_t count) {
  const std::size_t digits = fmt::formatted_size("{}", count - 1);
  return fmt::format("mask{:0{}}.tif", frame, std::max<std::size_t>(3, digits));
}

/// Fails if the folder has masks that are none of the frames to write, or a link under a name of
/// ours.
Result<void> checkOldFiles(const fs::path& folder, std::size_t count) {
  std::vector<std::string> own;
  for (std::size_t i = 0; i < count; ++i) own.push_back(nameOfFrame(i, count));
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("mask") || !name.ends_with(".tif")) continue;
    if (std::ranges::binary_search(own, name)) continue;
    return fail(ErrorCode::Failed,
                fmt::format("the folder has {}, which would pass for a frame of this series; "
                            "remove it or name another folder",
                            name),
                folder.string());
  }
  own.emplace_back(kTracksFile);
  return platform::checkReplaceable(folder, own, [](const fs::path&) { return true; });
}

/// The triangles of each track, with the points of the lattice at whole numbers.
std::map<std::uint64_t, model::TriangleMesh> partsOf(const model::TriangleMesh& slice,
                                                     const std::vector<std::uint64_t>& tracks,
                                                     const Point3& origin, const Point3& spacing) {
  std::map<std::uint64_t, model::TriangleMesh> parts;
  std::vector<std::uint32_t> numberOf(slice.vertices.size(), model::kNoIndex);
  // A vertex at which surfaces touch is one of each.
  std::vector<std::uint64_t> ofTrack(slice.vertices.size(), 0);
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (tracks[t] == 0) continue;
    model::TriangleMesh& part = parts[tracks[t]];
    model::Triangle triangle = slice.triangles[t];
    for (std::uint32_t& vertex : triangle) {
      if (ofTrack[vertex] != tracks[t]) {
        ofTrack[vertex] = tracks[t];
        numberOf[vertex] = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back((slice.vertices[vertex] - origin).cwiseQuotient(spacing));
      }
      vertex = numberOf[vertex];
    }
    part.triangles.push_back(triangle);
  }
  return parts;
}

/// The frames of labels, one after the other.
class Labels {
 public:
  Labels(std::uint64_t tracks, const Size& size)
      : size_(size),
        samples_(std::size_t{size[0]} * size[1] * size[2]),
        labelOf_(tracks + 1, 0),
        lastFrame_(tracks + 1, kNever),
        next_(tracks + 1) {}

  struct Line {
    std::uint64_t track;
    std::uint64_t first;
    std::uint64_t last;
    std::uint64_t before;  // label of the same track, or 0
  };

  void beginFrame(std::size_t frame) {
    frame_ = frame;
    std::ranges::fill(samples_, std::uint16_t{0});
  }

  /// Labels the points in a solid whose vertices count lattice points.
  Result<void> add(std::uint64_t track, const model::TriangleMesh& solid) {
    const model::Bounds3 bounds = model::boundsOf(solid);
    measure::SpaceLattice lattice;
    std::array<std::int64_t, 3> first{};
    Size begin{};  // of the points that are in the image, too
    Size end{};
    for (int axis = 0; axis < 3; ++axis) {
      const double least = std::floor(bounds.min[axis]) - 1;
      const double most = std::ceil(bounds.max[axis]) + 1;
      if (!(most - least < measure::SpaceLattice::kMostPoints)) {
        return fail(ErrorCode::Options,
                    fmt::format("a component is {:.6g} spacings long, expected fewer than {}",
                                most - least, measure::SpaceLattice::kMostPoints));
      }
      for (double at = least; at <= most; ++at) lattice.at[axis].push_back(at);
      const double size = size_[axis];
      if (most < 0 || least > size) return {};
      first[axis] = static_cast<std::int64_t>(least);
      begin[axis] = static_cast<std::uint32_t>(std::max(0.0, least));
      end[axis] = static_cast<std::uint32_t>(std::min(size, most + 1));
    }
    const measure::VisitLattice visits(solid, std::move(lattice), {}, /*withCrossings=*/false);
    for (std::uint32_t z = begin[2]; z < end[2]; ++z) {
      for (std::uint32_t y = begin[1]; y < end[1]; ++y) {
        for (std::uint32_t x = begin[0]; x < end[0]; ++x) {
          if (!visits.isInside({static_cast<std::uint32_t>(x - first[0]),
                                static_cast<std::uint32_t>(y - first[1]),
                                static_cast<std::uint32_t>(z - first[2])})) {
            continue;
          }
          if (lastFrame_[track] != frame_) {
            if (auto begun = beginTrack(track); !begun) return begun;
          }
          samples_[(std::size_t{z} * size_[1] + y) * size_[0] + x] =
              static_cast<std::uint16_t>(labelOf_[track]);
        }
      }
    }
    return {};
  }

  Result<std::string> tiff() const { return formats::tiffOf(samples_, size_); }

  /// The lines by label.
  const std::map<std::uint64_t, Line>& lines() const { return lines_; }
  /// The last label of a track; 0 if it has no point in any frame.
  std::uint64_t labelOf(std::uint64_t track) const { return labelOf_[track]; }

 private:
  static constexpr std::size_t kNever = ~std::size_t{0};

  /// Begins a track in this frame. Its label is that of the frame before.
  Result<void> beginTrack(std::uint64_t track) {
    const std::uint64_t before = labelOf_[track];
    const std::size_t last = std::exchange(lastFrame_[track], frame_);
    if (before != 0 && last + 1 == frame_) {
      lines_[before].last = frame_;
      return {};
    }
    const std::uint64_t label = before == 0 ? track : next_++;
    if (label > kMostLabels) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("there are more than {} labels, which is the most that these images "
                              "can hold; leave out small or short tracks",
                              kMostLabels));
    }
    labelOf_[track] = label;
    lines_[label] = {track, frame_, frame_, before};
    return {};
  }

  Size size_;
  std::vector<std::uint16_t> samples_;
  std::vector<std::uint64_t> labelOf_;  // by track
  std::vector<std::size_t> lastFrame_;
  std::map<std::uint64_t, Line> lines_;
  std::uint64_t next_;
  std::size_t frame_ = 0;
};

/// The lines of res_track.txt. The parent of a track is the largest of those that it comes out of,
/// or, if that one has no point in any frame, the parent of that one.
std::string tracksText(const TrackReport& report, const Labels& labels, std::uint64_t& lostLinks) {
  std::vector<const measure::Track*> tracks = {nullptr};
  std::vector<std::uint64_t> parents = {0};
  for (const BodyTracks& body : report.bodies) {
    for (const measure::Track& track : body.tracks.tracks) {
      std::uint64_t parent = 0;
      for (const std::uint32_t from : track.from) {
        const std::uint64_t id = body.firstId + from;
        if (parent == 0 || tracks[id]->largestVolume > tracks[parent]->largestVolume) parent = id;
      }
      tracks.push_back(&track);
      parents.push_back(parent);
    }
  }
  std::string text;
  for (const auto& [label, line] : labels.lines()) {
    std::uint64_t parent = line.before;
    if (parent == 0) {
      std::uint64_t track = parents[line.track];
      while (track != 0 && labels.labelOf(track) == 0) track = parents[track];
      parent = track == 0 ? 0 : labels.labelOf(track);
      const std::size_t from = tracks[line.track]->from.size();
      lostLinks += from > 1 ? from - 1 : 0;
    }
    text += fmt::format("{} {} {} {}\n", label, line.first, line.last, parent);
  }
  return text;
}

}  // namespace

Result<CtcReport> writeCtc(const Input& input, const TrackReport& report,
                           const std::vector<double>& times, const LabelLattice& lattice,
                           const std::string& folder, Observer& observer) {
  CtcReport written;
  const auto bounds = boundsOf(input);
  if (!bounds) return inInput(bounds.error(), input);
  written.origin = lattice.origin.value_or(bounds->min + lattice.spacing / 2);
  double points = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double past = (bounds->max[axis] - written.origin[axis]) / lattice.spacing[axis];
    const double count = lattice.size ? (*lattice.size)[axis] : std::max(1.0, std::ceil(past));
    points *= count;
    if (!(points <= kMostPoints)) {
      return fail(ErrorCode::Options,
                  fmt::format("a frame of labels has more than {} points; choose a larger spacing",
                              kMostPoints));
    }
    written.size[axis] = static_cast<std::uint32_t>(count);
  }
  if (auto made = formats::makeKeptFolder(folder); !made) return made.error();
  if (auto good = checkOldFiles(folder, times.size()); !good) return good.error();
  // A folder with a table of tracks is complete.
  if (auto done = convert::removeOldManifest(fs::path(folder) / kTracksFile); !done) {
    return done.error();
  }
  std::uint64_t tracks = 0;
  for (const BodyTracks& body : report.bodies) tracks += body.tracks.tracks.size();
  const SliceTracks slices(report);
  Labels labels(tracks, written.size);
  const auto stage = observer.stage("labelling", times.size(), "frames");
  const auto take = [&](std::size_t frame,
                        std::span<const formats::NamedMesh> meshes) -> Result<void> {
    labels.beginFrame(frame);
    for (const formats::NamedMesh& mesh : meshes) {
      const auto of = slices.of(mesh.name, mesh.mesh, times[frame]);
      for (const auto& [track, solid] : partsOf(mesh.mesh, of, written.origin, lattice.spacing)) {
        if (auto added = labels.add(track, solid); !added) return added;
      }
    }
    const auto bytes = labels.tiff();
    if (!bytes) return bytes.error();
    return formats::writeInFolder(folder, nameOfFrame(frame, times.size()), *bytes);
  };
  const auto done = convert::forEachFrame(input.bodies, times, {}, take, stage->callback());
  if (!done) return inInput(done.error(), input);
  const std::string text = tracksText(report, labels, written.lostLinks);
  if (auto put = formats::writeInFolder(folder, kTracksFile, text); !put) return put.error();
  written.frames = times.size();
  written.labels = labels.lines().size();
  return written;
}

}  // namespace t4d::tools
