#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "model/limits.h"
#include "platform/scratch_file.h"
#include "t4d/frames.h"
#include "t4d/mesh.h"
#include "voxel4d/frame_formats.h"
#include "voxel4d/frame_spacing.h"
#include "voxel4d/region_border.h"
#include "voxel4d/same_place.h"
#include "voxel4d/sample_box.h"
#include "voxel4d/volumes/frame_stream.h"
#include "voxel4d/volumes/header_text.h"
#include "voxel4d/volumes/headers.h"
#include "voxel4d/volumes/region_reader.h"
#include "voxel4d/volumes/sample_reader.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;

struct Row {
  platform::FileFormat format;
  Result<Volume> (*read)(const fs::path& path, const VolumeOptions& options);
};

Result<Volume> readNrrd(const fs::path& path, const VolumeOptions&) { return readNrrdHeader(path); }
Result<Volume> readNifti(const fs::path& path, const VolumeOptions&) {
  return readNiftiHeader(path);
}

Result<Volume> readNpy(const fs::path& path, const VolumeOptions& options) {
  return readNpyHeader(path, options.axes);
}

Result<Volume> readRaw(const fs::path& path, const VolumeOptions& options) {
  return readRawHeader(path, options.raw);
}

const std::vector<Row>& rows() {
  using Words = std::vector<std::string_view>;
  static const Words placed = {"densities", "labels", "place", "times", "units"};
  static const Words samples = {"densities", "labels", "masks"};
  static const std::vector<Row> table = {
      {{"NRRD", {".nrrd", ".nhdr"}, placed}, readNrrd},
      {{"NIfTI-1 and -2", {".nii", ".nii.gz", ".hdr"}, placed}, readNifti},
      {{"NumPy array", {".npy"}, samples}, readNpy},
      {{"bare samples", {".raw"}, samples}, readRaw},
  };
  return table;
}

/// The row for an extension that the name ends with; null for none.
const Row* rowOf(const fs::path& path) {
  std::string name = path.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const Row& row : rows()) {
    for (const std::string_view extension : row.format.extensions) {
      if (name.ends_with(extension)) return &row;
    }
  }
  return nullptr;
}

/// An error in the data of a volume says which header names them, if it is in another file.
Error ofData(Error error, const Volume& volume, const SampleData& data) {
  if (data.path.string() != volume.where) {
    error.message += fmt::format(" (the samples of {})", volume.where);
  }
  return error;
}

/// The samples of a file in which time is not the slowest axis, frame after frame: the file is read
/// once, and put into a temporary file in parts, each of which has all frames.
class FrameByFrame {
 public:
  /// A part has `inner` bytes of a frame for each step along the slower axes, of which there are
  /// `outer`.
  FrameByFrame(std::uint64_t inner, std::uint64_t frames, std::uint64_t outer)
      : inner_(inner),
        frames_(frames),
        outer_(outer),
        stepsInPart_(std::clamp<std::uint64_t>(kPart / (inner * frames), 1, outer)) {}

  /// Takes all samples from a reader that has come to the first.
  Result<void> fill(SampleReader& reader) {
    auto file = platform::ScratchFile::create();
    if (!file) return file.error();
    file_ = std::move(*file);
    std::vector<std::byte> bytes;
    std::vector<std::byte> sorted;
    for (std::uint64_t step = 0; step < outer_; step += stepsInPart_) {
      const std::uint64_t steps = std::min(stepsInPart_, outer_ - step);
      if (steps == 1) {
        // Its frames follow one another already.
        if (auto copied = copy(reader, bytes); !copied) return copied;
        continue;
      }
      bytes.resize(steps * frames_ * inner_);
      sorted.resize(bytes.size());
      if (auto read = reader.read(bytes); !read) return read;
      const std::byte* from = bytes.data();
      for (std::uint64_t i = 0; i < steps; ++i) {
        for (std::uint64_t frame = 0; frame < frames_; ++frame, from += inner_) {
          std::memcpy(sorted.data() + (frame * steps + i) * inner_, from, inner_);
        }
      }
      if (auto put = file_->append(sorted); !put) return put;
    }
    return {};
  }

  /// Sets `into` to bytes of a frame from number `from` on.
  Result<void> read(std::uint64_t frame, std::uint64_t from, std::span<std::byte> into) const {
    const std::uint64_t inPart = stepsInPart_ * inner_;  // of one frame
    while (!into.empty()) {
      const std::uint64_t part = from / inPart;
      const std::uint64_t steps = std::min(stepsInPart_, outer_ - part * stepsInPart_);
      const std::uint64_t at = from % inPart;
      const auto here = into.first(std::min<std::uint64_t>(into.size(), steps * inner_ - at));
      const std::uint64_t begin = part * inPart * frames_ + frame * steps * inner_;
      if (!file_->read(begin + at, here)) {
        return fail(ErrorCode::Failed,
                    "a temporary file cannot be read back (TMPDIR says where it is)");
      }
      from += here.size();
      into = into.subspan(here.size());
    }
    return {};
  }

 private:
  Result<void> copy(SampleReader& reader, std::vector<std::byte>& bytes) {
    for (std::uint64_t left = frames_ * inner_; left > 0; left -= bytes.size()) {
      bytes.resize(std::min(left, kPart));
      if (auto read = reader.read(bytes); !read) return read;
      if (auto put = file_->append(bytes); !put) return put;
    }
    return {};
  }

  static constexpr std::uint64_t kPart = std::uint64_t{1} << 24U;
  std::uint64_t inner_;
  std::uint64_t frames_;
  std::uint64_t outer_;
  std::uint64_t stepsInPart_;
  std::optional<platform::ScratchFile> file_;
};

/// The sides on which a volume goes on beyond its region.
RegionBorder borderOf(const Volume& volume) {
  std::array<IndexRange, 3> cut;
  std::array<std::int64_t, 3> offset{};
  for (std::size_t i = 0; i < volume.stored.size(); ++i) {
    if (volume.axes[i] == 't') continue;
    const auto& [size, first] = volume.stored[i];
    const std::size_t axis = volume.axes[i] - 'x';
    offset[axis] = static_cast<std::int64_t>(first);
    if (first > 0) cut[axis].begin = 0;
    if (first + volume.sizes[i] < size) cut[axis].end = volume.sizes[i];
  }
  return RegionBorder(cut, offset);
}

/// One frame after another of one or several volumes.
class Frames : public FrameSource {
 public:
  Frames(std::vector<Volume> volumes, std::vector<double> times, const Lattice& lattice,
         const VolumeOptions& options, const SampleRule& rule)
      : volumes_(std::move(volumes)),
        times_(std::move(times)),
        lattice_(lattice),
        options_(options),
        rule_(rule),
        border_(borderOf(volumes_.front())) {}

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return times_.size(); }
  bool isOneApart() const override {
    return !options_.frameTime && options_.times.empty() && !volumes_[0].frameTime &&
           volumes_[0].times.empty();
  }
  Place placeOf(std::size_t index) const override {
    if (volumes_.size() > 1) return volumes_[index].where;
    if (!volumes_[0].frameNames.empty()) return volumes_[0].frameNames[index];
    return placeIn(volumes_[0].where, fmt::format("frame {}", index + volumes_[0].first('t')));
  }
  std::string notice() const override { return border_.notice(); }

  void readsPart() override { solid_ = true; }

  Result<Frame> frame(std::size_t index) override {
    const Volume& volume = volumes_[volumes_.size() > 1 ? index : 0];
    const std::size_t size = samplesOfFrame(volume) * sizeOf(volume.type);
    const auto bytes = unusedBuffer(size);
    if (auto read = readFrame(index, volume, {bytes.get(), size}); !read) return read.error();
    const SampleBox box = boxOf(volume, bytes.get());
    SampleSigns signs = signsOf(box, rule_);
    if (!signs.usable) {
      return invalid(
          fmt::format("the sample ({}) of frame {} (counted from 0) is not finite, or too large",
                      indexText(volume, *firstUnusable(box, rule_)), at_ + volume.first('t')),
          volume.frameNames.empty() ? volume.where : volume.frameNames[at_]);
    }
    solid_ = solid_ || !signs.blocks.empty() || !signs.tiles.empty();
    if (index + 1 == times_.size() && !solid_ && !options_.valuesAlone) {
      return invalid(options_.label ? fmt::format("no sample of any frame is {}", *options_.label)
                     : options_.iso ? fmt::format("no sample of any frame is {} the iso value {}",
                                                  options_.below ? "below" : "above", *options_.iso)
                                    : std::string("no sample of any frame is inside"),
                     volumes_.front().where);
    }
    const auto outside = fieldOutside(rule_, signs.farthest);
    if (!outside) return outside.error();
    Frame frame = frameOf(box, rule_, std::move(signs), *outside, times_[index], bytes);
    border_.look(frame);
    return frame;
  }

 private:
  using Buffer = std::byte[];

  static std::uint64_t samplesOfFrame(const Volume& volume) {
    return volume.size('x') * volume.size('y') * volume.size('z');
  }

  /// Room for the samples of a frame, of which all have as many bytes. Few frames are in use at a
  /// time, and memory that was used before costs less than new, which is not touched before samples
  /// are there.
  std::shared_ptr<Buffer> unusedBuffer(std::size_t size) {
    const auto unused =
        std::ranges::find(buffers_, 1, [](const auto& buffer) { return buffer.use_count(); });
    return unused != buffers_.end()
               ? *unused
               : buffers_.emplace_back(std::make_shared_for_overwrite<Buffer>(size));
  }

  /// Reads the samples of a frame in the order of the file, each in the order of this machine.
  Result<void> readFrame(std::size_t index, const Volume& volume, std::span<std::byte> into) {
    const bool series = volumes_.size() > 1;
    const std::uint64_t frameInFile = series ? 0 : index;
    const std::size_t size = sizeOf(volume.type);
    // Runs of samples in a file: `inner` follow one another in one frame.
    std::uint64_t inner = 1;
    std::uint64_t outer = 1;
    const std::size_t time = std::min(volume.axes.find('t'), volume.axes.size());
    for (std::size_t i = 0; i < volume.sizes.size(); ++i) {
      if (i != time) (i < time ? inner : outer) *= volume.sizes[i];
    }
    const bool alone = volume.data.size() > 1;  // a file for each frame
    const std::uint64_t framesInFile = alone ? 1 : volume.frames();
    const SampleData& data = volume.data[alone ? frameInFile : 0];
    at_ = frameInFile;

    // Frames that follow one another are read in one go.
    if (!reader_ || series || alone) {
      auto reader = openRegion(volume, data);
      if (!reader) return ofData(reader.error(), volume, data);
      reader_ = std::move(*reader);
      if (framesInFile > 1 && outer > 1) {
        sorted_.emplace(inner * size, framesInFile, outer);
        if (auto done = sorted_->fill(*reader_); !done) return ofData(done.error(), volume, data);
      } else if (at_ > 0 && !alone) {  // a part of the frames begins here
        if (auto done = reader_->skip(at_ * into.size()); !done) {
          return ofData(done.error(), volume, data);
        }
      }
    }
    auto done = sorted_ ? sorted_->read(at_, 0, into) : reader_->read(into);
    if (!done) return ofData(done.error(), volume, data);
    if (volume.order != std::endian::native) reverseBytes(into, size);
    if (!alone && frameInFile + 1 < framesInFile) return {};
    done = reader_->finish(data.mayHaveMore);
    return done ? done : ofData(done.error(), volume, data);
  }

  /// Reverses the bytes of each number, which has `size` of them.
  static void reverseBytes(std::span<std::byte> numbers, std::size_t size) {
    for (std::size_t i = 0; i < numbers.size(); i += size) {
      std::ranges::reverse(numbers.subspan(i, size));
    }
  }

  static SampleBox boxOf(const Volume& volume, const std::byte* first) {
    SampleBox box{volume.type, first, {volume.size('x'), volume.size('y'), volume.size('z')}, {}};
    auto stride = static_cast<std::ptrdiff_t>(sizeOf(volume.type));
    for (std::size_t i = 0; i < volume.axes.size(); ++i) {
      if (volume.axes[i] == 't') continue;
      box.strides[volume.axes[i] - 'x'] = stride;
      stride *= static_cast<std::ptrdiff_t>(volume.sizes[i]);
    }
    return box;
  }

  /// "x 3, y 0, z 7", in the order of the file; `point` is (x, y, z).
  static std::string indexText(const Volume& volume, const std::array<std::size_t, 3>& point) {
    std::string text;
    for (const char name : volume.axes) {
      if (name == 't') continue;
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name,
                          point[name - 'x'] + volume.first(name));
    }
    return text;
  }

  std::vector<Volume> volumes_;  // one, or one for each frame
  std::vector<double> times_;
  Lattice lattice_;
  VolumeOptions options_;
  SampleRule rule_;
  RegionBorder border_;
  std::vector<std::shared_ptr<Buffer>> buffers_;
  std::unique_ptr<SampleReader> reader_;
  std::optional<FrameByFrame> sorted_;  // of a file in which time is not the slowest axis
  std::uint64_t at_ = 0;                // the frame in the file that is read
  bool solid_ = false;                  // whether any frame so far had a sample inside
};

Result<SampleRule> ruleOf(const Volume& volume, const VolumeOptions& options) {
  SampleRule rule;
  if (options.outside && (options.label || volume.type == SampleType::Bool)) {
    return invalid("labels and bools say what is outside; no value for it can be given",
                   volume.where);
  }
  rule.outside = options.outside;
  if (options.label) {
    if (options.iso) return invalid("an iso value and a label are given; they exclude each other");
    if (volume.slope != 1 || volume.intercept != 0) {
      return invalid(fmt::format("scales its samples by {} and adds {}, so they are not labels",
                                 volume.slope, volume.intercept),
                     volume.where);
    }
    rule.mask = true;
    rule.label = options.label;
    return rule;
  }
  const bool isMask = volume.type == SampleType::Bool || volume.mask;
  if (isMask && options.valuesAlone) {
    return invalid("has bools as samples; expected numbers", volume.where);
  }
  if (isMask) {
    rule.mask = true;
    if (!options.iso) return rule;
    return invalid("an iso value is given, but its samples are bools", volume.where);
  }
  if (options.iso && !std::isfinite(*options.iso)) {
    return invalid(fmt::format("the iso value is {}", *options.iso));
  }
  if (!options.iso && isInteger(volume.type) && !options.valuesAlone) {
    return invalid(
        "has whole numbers as samples, which do not say what is inside; an iso value or a label "
        "must be given",
        volume.where, Remedy::IsoValue);
  }
  rule.slope = volume.slope;
  rule.intercept = volume.intercept;
  if (options.iso) rule.sign = options.below ? 1 : -1, rule.iso = *options.iso;
  rule.floats = fitsFloat32(volume.type) && volume.slope == 1 && volume.intercept == 0;
  // Differences of values must be finite, too.
  rule.largest =
      rule.floats ? std::numeric_limits<float>::max() / 8 : std::numeric_limits<double>::max() / 8;
  return rule;
}

Result<void> checkAlike(const Volume& first, const Volume& other) {
  if (other.frames() > 1) {
    return invalid(fmt::format("holds {} frames; where there are several files, each must hold one",
                               other.frames()),
                   other.where);
  }
  for (const char axis : {'x', 'y', 'z'}) {
    if (other.size(axis) == first.size(axis)) continue;
    const bool more = other.size(axis) > first.size(axis);
    return invalid(fmt::format("has {} samples along {}, {} {} than the first frame ({}), which "
                               "has {}",
                               other.size(axis), axis,
                               more ? other.size(axis) - first.size(axis)
                                    : first.size(axis) - other.size(axis),
                               more ? "more" : "fewer", first.where, first.size(axis)),
                   other.where);
  }
  if (other.type != first.type) {
    return invalid(fmt::format("has samples of type {}, the first frame ({}) of type {}",
                               nameOf(other.type), first.where, nameOf(first.type)),
                   other.where);
  }
  if (other.slope != first.slope || other.intercept != first.intercept) {
    return invalid(
        fmt::format("scales its samples by {} and adds {}, the first frame ({}) by {} "
                    "and {}",
                    other.slope, other.intercept, first.where, first.slope, first.intercept),
        other.where);
  }
  if (other.lengthUnit != first.lengthUnit || other.timeUnit != first.timeUnit) {
    return invalid(fmt::format("has the units '{}' and '{}', the first frame ({}) '{}' and '{}'",
                               other.lengthUnit, other.timeUnit, first.where, first.lengthUnit,
                               first.timeUnit),
                   other.where);
  }
  if (other.space != first.space) {
    return invalid(fmt::format("has positions in the space '{}', the first frame ({}) in '{}'",
                               other.space, first.where, first.space),
                   other.where);
  }
  return {};
}

/// The first point that is read, in samples from the first that is stored.
Eigen::Vector3d firstOf(const Volume& volume) {
  Eigen::Vector3d first;
  for (int axis = 0; axis < 3; ++axis) first[axis] = static_cast<double>(volume.first("xyz"[axis]));
  return first;
}

Result<model::Affine3x4> placeOf(const Volume& volume, const VolumeOptions& options) {
  model::Affine3x4 place = volume.place;
  for (int axis = 0; options.spacing && axis < 3; ++axis) {
    // The directions of the file's axes stay.
    const double length = place.col(axis).norm();
    place.col(axis) *= length > 0 ? (*options.spacing)[axis] / length : 1;
  }
  if (options.origin) place.col(3) = Eigen::Vector3d(options.origin->data());
  place.col(3) += place.leftCols<3>() * firstOf(volume);
  const double longest = place.leftCols<3>().colwise().norm().maxCoeff();
  const double volumeOfVoxel = std::abs(place.leftCols<3>().determinant());
  constexpr double kFlat = 1e-9;  // of a cube with the longest edge: such voxels are damage
  if (!place.allFinite() || !(volumeOfVoxel > kFlat * longest * longest * longest)) {
    return invalid("has voxels without volume, or without a place in space", volume.where);
  }
  if (place.cwiseAbs().maxCoeff() > model::kLargestCoordinate) {
    return invalid(
        fmt::format("places samples beyond {}, the largest coordinate", model::kLargestCoordinate),
        volume.where);
  }
  return place;
}

/// The largest difference of two placements of `size` samples, for a message.
std::string differenceOf(const model::Affine3x4& first, const model::Affine3x4& other,
                         const Eigen::Vector3d& size) {
  constexpr std::array<std::string_view, 4> kParts = {"voxel edge along x", "voxel edge along y",
                                                      "voxel edge along z", "first sample"};
  int most = 3;
  const auto shift = [&](int column) {
    return (other.col(column) - first.col(column)).norm() * (column < 3 ? size[column] : 1);
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (shift(axis) > shift(most)) most = axis;
  }
  const auto text = [&](const model::Affine3x4& place) {
    return fmt::format("({}, {}, {})", place(0, most), place(1, most), place(2, most));
  };
  return fmt::format("its {} is {}, that of the first frame {}", kParts[most], text(other),
                     text(first));
}

/// Fails if samples of a file are elsewhere in space than those of the first frame.
Result<void> checkSamePlace(const Volume& first, const Volume& other,
                            const VolumeOptions& options) {
  const auto expected = placeOf(first, options);
  if (!expected) return expected.error();
  const auto found = placeOf(other, options);
  if (!found) return found.error();
  Eigen::Vector3d last;
  for (int axis = 0; axis < 3; ++axis) {
    last[axis] = static_cast<double>(first.size("xyz"[axis]) - 1);
  }
  const double apart = voxelsApart(*expected, *found, Eigen::Vector3d::Zero(), last);
  if (apart <= kSamePlace) return {};
  return invalid(
      fmt::format("is placed elsewhere in space than the first frame ({}): a corner of its samples "
                  "is {:.4g} voxels away from there; up to {} are taken for rounding; {}",
                  first.where, apart, kSamePlace, differenceOf(*expected, *found, last)),
      other.where);
}

/// The samples of all dimensions are there, as far as sizes of files tell.
Result<void> checkSizes(const Volume& volume) {
  const auto bytes = bytesOfSamples(volume);
  if (!bytes) return bytes.error();
  for (const SampleData& data : volume.data) {
    if (data.stream) continue;  // nothing says how long it is
    const auto opened = openSamples(data, volume.type, data.begin + *bytes / volume.data.size());
    if (!opened) return ofData(opened.error(), volume, data);
  }
  return {};
}

/// Leaves of a volume what is to be read, and of its own frames `frames`.
Result<void> crop(Volume& volume, const std::array<IndexRange, 3>& region, const Extent& frames) {
  std::map<char, Extent> read = {{'t', frames}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const char name = "xyz"[axis];
    const auto extent = extentOf(region[axis], name, volume.size(name), volume.where);
    if (!extent) return extent.error();
    read[name] = *extent;
  }
  for (std::size_t i = 0; i < volume.axes.size(); ++i) {
    const Extent& extent = read[volume.axes[i]];
    volume.stored.push_back({volume.sizes[i], extent.begin});
    volume.sizes[i] = extent.count;
  }
  if (volume.data.size() > 1) keep(volume.data, frames);
  return {};
}

/// The times of the frames that are read, out of all `frameCount` of the files.
Result<std::vector<double>> timesOf(const Volume& first, std::uint64_t frameCount,
                                    const Extent& frames, const VolumeOptions& options) {
  const std::uint64_t count = frames.count;
  if (count > kMaxFrames) {
    return invalid(fmt::format("has {} frames; at most {} are allowed", count, kMaxFrames),
                   first.where);
  }
  if (!options.times.empty()) {
    if (auto good = checkFrameTimes(options.times, frameCount); !good) {
      return invalid(good.error().message, first.where);
    }
    std::vector<double> times = options.times;
    keep(times, frames);
    return times;
  }
  const auto step =
      options.frameTime ? options.frameTime : std::optional(first.frameTime.value_or(1));
  const double start = options.startTime.value_or(first.startTime);
  if (!(*step > 0 && std::isfinite(*step) && std::isfinite(start))) {
    return invalid(fmt::format("frames are {} apart from time {} on; expected a positive number",
                               *step, start),
                   first.where, Remedy::FrameTime);
  }
  const bool own = !options.frameTime && !first.times.empty();
  std::vector<double> times;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t number = frames.begin + i;
    times.push_back(own ? start + (first.times[number] - first.times[0])
                        : model::steppedTime(start, *step, number));
    if (!(std::abs(times.back()) <= model::kLargestCoordinate)) {
      return invalid(fmt::format("frame {} is at time {}; the largest possible is {}", number,
                                 times[i], model::kLargestCoordinate),
                     first.where, number == 0 ? Remedy::None : Remedy::FrameTime);
    }
    if (i > 0 && !(times[i] > times[i - 1])) {
      return invalid(
          fmt::format("frames are {} apart from time {} on: doubles are too coarse there "
                      "to tell frame {} from the one before",
                      *step, start, number),
          first.where, Remedy::FrameTime);
    }
  }
  return times;
}

}  // namespace

std::vector<platform::FileFormat> volumeFormats() {
  std::vector<platform::FileFormat> all;
  for (const Row& row : rows()) all.push_back(row.format);
  return all;
}

std::vector<std::string_view> volumeExtensions() {
  std::vector<std::string_view> all;
  for (const Row& row : rows()) {
    all.insert(all.end(), row.format.extensions.begin(), row.format.extensions.end());
  }
  return all;
}

bool isVolumeFile(const fs::path& path) { return rowOf(path) != nullptr; }

Result<VolumeFrames> openVolumeFrames(std::span<const fs::path> files,
                                      const VolumeOptions& options) {
  if (files.empty()) return invalid("no frames: no file is given");
  std::vector<Volume> volumes;
  for (const fs::path& file : files) {
    const bool isStream = file == "-";
    const Row* row = rowOf(file);
    if (row == nullptr && !isStream) {
      return invalid("is not a volume by its extension", file.string());
    }
    auto volume = isStream ? readFrameStream(options.input) : row->read(file, options);
    if (!volume) return volume.error();
    if (auto checked = checkSizes(*volume); !checked) return checked.error();
    if (files.size() > 1) {
      const Volume& first = volumes.empty() ? *volume : volumes.front();
      if (auto alike = checkAlike(first, *volume); !alike) return alike.error();
      if (auto same = checkSamePlace(first, *volume, options); !same) return same.error();
    }
    volumes.push_back(std::move(*volume));
  }
  const Volume& first = volumes.front();
  const std::size_t count = files.size() > 1 ? files.size() : first.frames();
  if (count < 2) {
    return invalid("has one frame only; a 4D mesh needs two or more", first.where);
  }
  Extent frames{0, count};
  if (options.region) {
    const auto used = extentOf(options.region->time, 't', count, first.where);
    if (!used) return used.error();
    frames = *used;
    for (Volume& volume : volumes) {
      auto cropped = crop(volume, options.region->space, files.size() > 1 ? Extent{0, 1} : frames);
      if (!cropped) return cropped.error();
    }
  }
  const auto rule = ruleOf(first, options);
  if (!rule) return rule.error();
  const auto place = placeOf(first, options);
  if (!place) return place.error();
  auto times = timesOf(first, count, frames, options);
  if (!times) return times.error();

  VolumeFrames opened;
  opened.space = first.space;
  opened.notice = first.notice;
  for (const char axis : {'x', 'y', 'z'}) {
    const bool isUnsized = first.unsized.find(axis) != std::string::npos && first.size(axis) > 1;
    if (isUnsized && !options.spacing) opened.unsized += axis;
  }
  opened.assumedAxes = first.assumedAxes;
  opened.sizes = {first.size('x'), first.size('y'), first.size('z')};
  opened.takenAsDistances = !rule->mask && !options.iso;
  opened.lengthUnit = first.lengthUnit;
  opened.timeUnit = first.timeUnit;
  opened.name = first.name;
  opened.notes = first.notes;
  opened.losses = first.losses;
  Lattice lattice;
  const double edge = (*place)(0, 0);
  if (edge > 0 && place->leftCols<3>() == edge * Eigen::Matrix3d::Identity()) {
    lattice = {edge, place->col(3)};
  } else {
    opened.toSpace = *place;
  }
  if (files.size() > 1) keep(volumes, frames);
  opened.frames =
      std::make_unique<Frames>(std::move(volumes), std::move(*times), lattice, options, *rule);
  return opened;
}

}  // namespace t4d::voxel4d
