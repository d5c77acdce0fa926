#include "voxel4d/volumes/frame_stream.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "voxel4d/volumes/header_text.h"
#include "voxel4d/volumes/npy_array.h"
#include "voxel4d/volumes/sample_reader.h"
#include "voxel4d/volumes/volume.h"

namespace t4d::voxel4d {
namespace {

using nlohmann::json;

constexpr const char* kStandardInput = "standard input";

/// The members of the header.
constexpr std::array kMembers = {"format",       "version",     "size",      "frames", "times",
                                 "affine",       "unsized",     "space",     "mask",   "names",
                                 "assumed_axes", "notes",       "time_unit", "losses", "name",
                                 "part",         "length_unit", "region"};

/// What is wrong with the header, which an exception carries within this file.
struct Fault {
  std::string text;
};

const json& require(const json& header, const char* name) {
  const auto found = header.find(name);
  if (found == header.end()) throw Fault{fmt::format("has no '{}'", name)};
  return *found;
}

std::uint64_t count(const json& value, const std::string& name, std::uint64_t least) {
  constexpr std::uint64_t kMost = (std::uint64_t{1} << 31U) - 1;
  const bool whole = value.is_number_unsigned() && value.get<std::uint64_t>() >= least;
  if (!whole || value.get<std::uint64_t>() > kMost) {
    throw Fault{fmt::format("'{}' is {}; expected a whole number from {} to {}", name,
                            shown(value.dump()), least, kMost)};
  }
  return value.get<std::uint64_t>();
}

double number(const json& value, const std::string& name) {
  if (!value.is_number()) {
    throw Fault{fmt::format("'{}' has {}; expected a number", name, shown(value.dump()))};
  }
  return value.get<double>();
}

std::string text(const json& header, const char* name) {
  const json value = header.value(name, json(""));
  if (!value.is_string()) throw Fault{fmt::format("'{}' is not a text", name)};
  return value.get<std::string>();
}

/// The elements of an array of `size` elements, or of any number.
const json& array(const json& value, const std::string& name,
                  std::optional<std::uint64_t> size = {}) {
  if (!value.is_array() || (size && value.size() != *size)) {
    throw Fault{fmt::format("'{}' is not an array{}", name,
                            size ? fmt::format(" of {} elements", *size) : "")};
  }
  return value;
}

std::vector<std::string> texts(const json& header, const char* name,
                               std::optional<std::uint64_t> size = {}) {
  std::vector<std::string> all;
  if (!header.contains(name)) return all;
  for (const json& value : array(header[name], name, size)) {
    if (!value.is_string()) throw Fault{fmt::format("'{}' has {}", name, shown(value.dump()))};
    all.push_back(value.get<std::string>());
  }
  return all;
}

std::array<std::uint64_t, 3> counts(const json& value, const std::string& name,
                                    std::uint64_t least) {
  std::array<std::uint64_t, 3> all{};
  for (std::size_t i = 0; i < 3; ++i) all[i] = count(array(value, name, 3)[i], name, least);
  return all;
}

json parse(const std::string& line) {
  std::vector<std::set<std::string>> keys;  // of each object that is open
  std::string twice;
  const auto look = [&](int depth, json::parse_event_t event, json& parsed) {
    using Event = json::parse_event_t;
    constexpr int kDeepest = 2;  // the rows of the affine
    if (depth > kDeepest && (event == Event::object_start || event == Event::array_start)) {
      throw Fault{"its first line has members within members that no header has"};
    }
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key && !keys.back().insert(parsed.get<std::string>()).second) {
      twice = parsed.get<std::string>();
    }
    return true;
  };
  json header = json::parse(line, look, false);
  if (!header.is_object()) throw Fault{"its first line is not an object of JSON"};
  if (!twice.empty()) throw Fault{fmt::format("has '{}' twice", shown(twice))};
  for (const auto& [name, value] : header.items()) {
    if (std::ranges::find(kMembers, name) == kMembers.end()) {
      throw Fault{fmt::format("has the unknown member '{}'", shown(name))};
    }
  }
  return header;
}

/// Where the samples are, and of which region of the source they are.
void placeSamples(const json& header, Volume& volume) {
  volume.unsized = header.contains("affine") ? text(header, "unsized") : "xyz";
  if (header.contains("affine")) {
    const json& rows = array(header["affine"], "affine", 3);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        volume.place(row, column) = number(array(rows[row], "affine", 4)[column], "affine");
      }
    }
  }
  if (!header.contains("region")) return;
  const json& region = header["region"];
  if (!region.is_object() || region.size() != 2) {
    throw Fault{"'region' is not an object with 'size' and 'first'"};
  }
  const auto size = counts(require(region, "size"), "region", 1);
  const auto first = counts(require(region, "first"), "region", 0);
  for (std::size_t i = 0; i < volume.axes.size(); ++i) {
    if (volume.axes[i] == 't') {
      volume.stored.push_back({volume.sizes[i], 0});
      continue;
    }
    const std::size_t axis = volume.axes[i] - 'x';
    if (first[axis] + volume.sizes[i] > size[axis]) {
      throw Fault{
          fmt::format("'region' has no {} samples along {}", volume.sizes[i], volume.axes[i])};
    }
    volume.stored.push_back({size[axis], first[axis]});
    // The affine is of the first sample that follows.
    volume.place.col(3) -= volume.place.col(axis) * static_cast<double>(first[axis]);
  }
}

/// The .npy header of a frame.
Result<NpyArray> readArray(InputBytes& input, const std::string& where, std::uint64_t frame) {
  return readNpyArray([&](std::span<std::byte> into) { return input.read(into); },
                      placeIn(where, fmt::format("frame {}", frame)));
}

/// One frame after another; a request has the bytes of a frame.
class FrameReader : public SampleReader {
 public:
  /// The next frame is `first`, whose .npy header has been read.
  FrameReader(std::shared_ptr<InputBytes> input, NpyArray array, std::string where,
              std::uint64_t frameBytes, std::uint64_t first, std::uint64_t last)
      : input_(std::move(input)),
        array_(std::move(array)),
        where_(std::move(where)),
        frameBytes_(frameBytes),
        next_(first),
        last_(last) {}

  Result<void> skip(std::uint64_t bytes) override {
    wanted_ += bytes / frameBytes_;
    return {};
  }
  Result<void> read(std::span<std::byte> into) override {
    if (next_ > wanted_) {
      return invalid(
          fmt::format("begins with frame {}, but frame {} is needed: it has another part "
                      "of the frames",
                      next_, wanted_),
          where_);
    }
    if (wanted_ > last_) {
      return invalid(fmt::format("ends with frame {}, but frame {} is needed: it has another part "
                                 "of the frames",
                                 last_, wanted_),
                     where_);
    }
    for (;; ++next_) {
      if (auto begun = begin(); !begun) return begun;
      const auto got = input_->read(into);
      if (!got) return got.error();
      if (*got < into.size()) return cutOff();
      if (next_ == wanted_) break;
    }
    ++next_;
    ++wanted_;
    return {};
  }
  Result<void> finish(bool) override {
    std::array<std::byte, 1> more{};
    const auto got = input_->read(more);
    if (!got) return got.error();
    if (*got == 0) return {};
    return invalid("has bytes after the last of the frames that its header announces", where_);
  }

 private:
  Error cutOff() const { return invalid(fmt::format("ends within frame {}", next_), where_); }

  /// Reads the .npy header of the next frame, unless that was done.
  Result<void> begin() {
    if (std::exchange(begun_, false)) return {};
    auto found = readArray(*input_, where_, next_);
    if (!found) return found.error();
    if (*found == array_) return {};
    return invalid(fmt::format("frame {} differs from the first in its shape, the type of its "
                               "samples or their order",
                               next_),
                   where_);
  }

  std::shared_ptr<InputBytes> input_;
  NpyArray array_;
  std::string where_;
  std::uint64_t frameBytes_;
  std::uint64_t next_;        // that follows
  std::uint64_t last_;        // that follows
  std::uint64_t wanted_ = 0;  // by the next request
  bool begun_ = true;
};

/// The first line, without its end.
Result<std::string> readLine(InputBytes& input) {
  constexpr std::size_t kLongest = std::size_t{1} << 25U;
  std::string line;
  for (std::array<std::byte, 1> next{}; line.size() <= kLongest;) {
    const auto got = input.read(next);
    if (!got) return got.error();
    if (*got == 0) break;
    if (next[0] == std::byte{'\n'}) return line;
    line += static_cast<char>(next[0]);
  }
  return invalid(
      line.empty() ? "is empty" : "its first line is not the header of a stream of frames (JSON)",
      kStandardInput);
}

/// The volume that the header describes; `first` is the first frame that follows.
Volume volumeOf(const json& header, const NpyArray& samples, std::uint64_t first) {
  Volume volume;
  const auto sizes = counts(require(header, "size"), "size", 1);
  volume.where = text(header, "name").empty() ? kStandardInput : text(header, "name");
  volume.name = text(header, "name");
  if (!std::ranges::equal(samples.shape, sizes)) {
    throw Fault{fmt::format("frame {} does not have the shape that the header announces", first)};
  }
  const std::uint64_t frames = count(require(header, "frames"), "frames", 1);
  volume.type = samples.type;
  volume.order = samples.order;
  volume.axes = samples.fortran ? "xyzt" : "zyxt";
  volume.sizes = {sizes[0], sizes[1], sizes[2], frames};
  if (!samples.fortran) std::swap(volume.sizes[0], volume.sizes[2]);
  placeSamples(header, volume);
  if (header.contains("times")) {
    for (const json& time : array(header["times"], "times", frames)) {
      volume.times.push_back(number(time, "times"));
    }
    for (std::size_t i = 1; i < volume.times.size(); ++i) {
      if (volume.times[i] > volume.times[i - 1]) continue;
      throw Fault{fmt::format("times do not increase: frame {} is at {}, the one before at {}", i,
                              volume.times[i], volume.times[i - 1])};
    }
    volume.startTime = volume.times.front();
  }
  volume.lengthUnit = text(header, "length_unit");
  volume.timeUnit = text(header, "time_unit");
  volume.space = text(header, "space");
  if (!volume.space.empty() && volume.space != "RAS" && volume.space != "LPS") {
    throw Fault{fmt::format("'space' is '{}'; expected RAS or LPS", shown(volume.space))};
  }
  const json mask = header.value("mask", json(false));
  if (!mask.is_boolean()) throw Fault{"'mask' is neither true nor false"};
  volume.mask = mask.get<bool>();
  if (volume.mask && sizeOf(volume.type) > 1) {
    throw Fault{fmt::format("'mask' is true, but samples are {}; those of masks have one byte",
                            nameOf(volume.type))};
  }
  volume.frameNames = texts(header, "names", frames);
  volume.assumedAxes = fmt::format("{}", fmt::join(texts(header, "assumed_axes"), ", "));
  volume.notes = texts(header, "notes");
  volume.losses = texts(header, "losses");
  return volume;
}

}  // namespace

Result<void> InputBytes::begin() {
  if (taken_ > 0 && !keep_) {
    return fail(ErrorCode::Failed, "is to be read again, but was not kept", kStandardInput);
  }
  at_ = 0;
  return {};
}

Result<std::size_t> InputBytes::read(std::span<std::byte> into) {
  constexpr std::size_t kWindow = std::size_t{1} << 16U;
  const std::size_t wanted = into.size();
  while (!into.empty()) {
    std::size_t got = 0;
    if (at_ >= windowBegin_ && at_ < windowBegin_ + window_.size()) {
      const auto here = std::span(window_).subspan(at_ - windowBegin_);
      got = std::min(here.size(), into.size());
      std::ranges::copy(here.first(got), into.begin());
    } else if (at_ < taken_) {
      got = static_cast<std::size_t>(std::min<std::uint64_t>(into.size(), taken_ - at_));
      if (!copy_->read(at_, into.first(got))) {
        return fail(ErrorCode::Failed,
                    "a temporary file cannot be read back (TMPDIR says where it is)");
      }
    } else if (into.size() >= kWindow) {
      const auto taken = take(into);
      if (!taken) return taken.error();
      got = *taken;
    } else {
      windowBegin_ = taken_;
      window_.resize(kWindow);
      const auto taken = take(window_);
      if (!taken) return taken.error();
      window_.resize(*taken);
      if (window_.empty()) break;
    }
    if (got == 0 && at_ == taken_) break;
    at_ += got;
    into = into.subspan(got);
  }
  return wanted - into.size();
}

Result<std::size_t> InputBytes::take(std::span<std::byte> into) {
  if (!input_) {
    auto file = platform::OpenFile::open("-");
    if (!file) return file.error();
    input_ = std::move(*file);
  }
  const auto count = input_->read(into);
  if (!count) return count;
  taken_ += *count;
  if (!keep_) return count;
  if (!copy_) {
    auto file = platform::ScratchFile::create();
    if (!file) return file.error();
    copy_ = std::move(*file);
  }
  if (auto put = copy_->append(into.first(*count)); !put) return put.error();
  return count;
}

Result<Volume> readFrameStream(std::shared_ptr<InputBytes> input) {
  if (input == nullptr) input = std::make_shared<InputBytes>(false);
  if (auto begun = input->begin(); !begun) return begun.error();
  const auto line = readLine(*input);
  if (!line) return line.error();
  try {
    const json header = parse(*line);
    if (text(header, "format") != "t4d-frames" || require(header, "version") != 1) {
      throw Fault{"is not a stream of frames of version 1: its 'format' and 'version' are others"};
    }
    const std::uint64_t frames = count(require(header, "frames"), "frames", 1);
    std::uint64_t first = 0;
    std::uint64_t last = frames - 1;
    if (header.contains("part")) {
      first = count(array(header["part"], "part", 2)[0], "part", 0);
      last = count(header["part"][1], "part", first);
      if (last >= frames) throw Fault{"'part' goes beyond the last frame"};
    }
    auto samples = readArray(*input, kStandardInput, first);
    if (!samples) return samples.error();
    Volume volume = volumeOf(header, *samples, first);
    const auto bytes = bytesOfSamples(volume);
    if (!bytes) return bytes.error();
    SampleData data{.path = volume.where, .encoding = SampleEncoding::Stream};
    data.stream = std::make_shared<FrameReader>(std::move(input), std::move(*samples), volume.where,
                                                *bytes / volume.frames(), first, last);
    volume.data = {std::move(data)};
    return volume;
  } catch (const Fault& fault) {
    return invalid(fault.text, kStandardInput);
  }
}

}  // namespace t4d::voxel4d
