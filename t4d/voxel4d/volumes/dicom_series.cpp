#include "t4d/voxel4d/volumes/dicom_series.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <unistd.h>

#include "t4d/voxel4d/natural_order.h"
#include "t4d/voxel4d/volumes/header_text.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;

/// Positions are rounded when they are written as decimals.
constexpr double kSamePlace = 1e-3;     // mm
constexpr double kUnevenSlices = 0.01;  // of the distance of two slices
constexpr double kSameDirection = 1e-4;

constexpr std::array<std::string_view, kDicomTimes> kTimeNames = {
    "TriggerTime (s)",    "time of the temporal position (s)",
    "FrameReferenceTime", "AcquisitionTime (s)",
    "ContentTime (s)",    "TemporalPositionIdentifier"};

/// One series as it was found.
struct Series {
  std::string number;
  std::string description;
  std::vector<fs::path> files;
  std::vector<DicomFile> contents;
};

/// Also a file that cannot be read, so that this is an error.
bool mayBeImage(const fs::directory_entry& entry) {
  std::error_code ignored;
  const fs::path& path = entry.path();
  if (path.filename() == "DICOMDIR" || !entry.is_regular_file(ignored)) return false;
  return hasDicomSignature(path) || lowerCase(path.extension().string()) == ".dcm" ||
         access(path.c_str(), R_OK) != 0;
}

Result<std::vector<fs::path>> filesOf(std::span<const fs::path> inputs) {
  std::vector<fs::path> files;
  for (const fs::path& input : inputs) {
    std::error_code problem;
    if (!fs::is_directory(input, problem)) {
      files.push_back(input);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(input, problem)) {
      if (mayBeImage(entry)) files.push_back(entry.path());
    }
    if (problem) {
      return fail(ErrorCode::Io, "cannot be read: " + problem.message(), input.string());
    }
  }
  std::ranges::sort(files, [](const fs::path& a, const fs::path& b) {
    return naturallyLess(a.string(), b.string());
  });
  return files;
}

std::string listOf(const std::map<std::string, Series>& all) {
  constexpr std::size_t kMostListed = 20;
  std::string list;
  std::size_t listed = 0;
  for (const auto& [uid, series] : all) {
    if (listed++ == kMostListed) {
      list += fmt::format("; and {} more", all.size() - kMostListed);
      break;
    }
    list += fmt::format("{}{} '{}' of {} files, {}", list.empty() ? "" : "; ",
                        series.number.empty() ? "without a number" : shown(series.number),
                        shown(series.description), series.files.size(),
                        shown(std::string_view(uid).substr(0, 64)));
  }
  return list;
}

/// The series that is wanted, or the only one.
Result<Series> choose(std::map<std::string, Series> all, const std::string& wanted,
                      const std::string& where) {
  std::vector<Series*> found;
  for (auto& [uid, series] : all) {
    if (wanted.empty() || uid == wanted || series.number == wanted) found.push_back(&series);
  }
  if (found.size() == 1) return std::move(*found.front());
  if (wanted.empty()) {
    return invalid(fmt::format("holds {} series, of which one can be read at a time: {}",
                               all.size(), listOf(all)),
                   where, Remedy::GridName);
  }
  return invalid(fmt::format("holds {} series '{}'; there are: {}",
                             found.empty() ? "no" : "several", shown(wanted), listOf(all)),
                 where, Remedy::GridName);
}

/// Images of a series and how they lie.
class Arrangement {
 public:
  explicit Arrangement(std::string where) : where_(std::move(where)) {}

  Result<Volume> arrange(Series series) {
    for (auto step : {&Arrangement::collect, &Arrangement::findPlaces}) {
      if (auto done = (this->*step)(series); !done) return done.error();
    }
    auto times = findTimes();
    if (!times) return times.error();
    return volume(std::move(*times));
  }

 private:
  const std::string& fileOf(const DicomImage& image) const {
    return planes_->files[image.file].native();
  }
  Error differs(std::size_t number, const std::string& own, const std::string& first) const {
    return invalid(fmt::format("has {}, but {} in the same series has {}", own,
                               planes_->files[0].string(), first),
                   planes_->files[number].string());
  }
  static std::string samplesText(const DicomLayout& layout, bool inverted) {
    return fmt::format("samples of type {} with {} bits{}", nameOf(layout.type()), layout.stored,
                       inverted ? ", inverted (MONOCHROME1)" : "");
  }
  static std::string syntaxText(const DicomLayout& layout) {
    return fmt::format("the transfer syntax {}{}", shown(layout.syntax),
                       layout.bigEndian ? ", big-endian" : "");
  }

  /// All images, with one layout, direction and spacing.
  Result<void> collect(Series& series) {
    for (const DicomFile& file : series.contents) {
      if (file.fault) return *file.fault;
    }
    planes_->files = std::move(series.files);
    planes_->layout = series.contents.front().layout;
    inverted_ = series.contents.front().inverted;
    const DicomLayout& layout = planes_->layout;
    for (std::size_t i = 0; i < series.contents.size(); ++i) {
      DicomFile& file = series.contents[i];
      if (file.layout.columns != layout.columns || file.layout.rows != layout.rows) {
        const auto sizeText = [](const DicomLayout& of) {
          return fmt::format("{} columns and {} rows", of.columns, of.rows);
        };
        return differs(i, sizeText(file.layout), sizeText(layout));
      }
      if (file.layout.type() != layout.type() || file.layout.stored != layout.stored ||
          file.inverted != inverted_) {
        return differs(i, samplesText(file.layout, file.inverted), samplesText(layout, inverted_));
      }
      if (file.layout.syntax != layout.syntax || file.layout.bigEndian != layout.bigEndian) {
        return differs(i, syntaxText(file.layout), syntaxText(layout));
      }
      for (DicomImage& image : file.images) {
        image.file = static_cast<std::uint32_t>(i);
        if (auto good = checkImage(image); !good) return good;
        planes_->images.push_back(std::move(image));
      }
    }
    return {};
  }

  Result<void> checkImage(const DicomImage& image) const {
    const std::string& where = fileOf(image);
    if (!image.position || !image.orientation) {
      return invalid(
          "does not say where its image is in space (ImagePositionPatient and "
          "ImageOrientationPatient)",
          where);
    }
    if (!image.spacing || !((*image.spacing)[0] > 0 && (*image.spacing)[1] > 0)) {
      return invalid("does not say how far apart its samples are (PixelSpacing)", where);
    }
    const Eigen::Vector3d row(image.orientation->data());
    const Eigen::Vector3d column(image.orientation->data() + 3);
    constexpr double kSkew = 1e-3;
    if (!(std::abs(row.norm() - 1) < kSkew && std::abs(column.norm() - 1) < kSkew &&
          std::abs(row.dot(column)) < kSkew)) {
      return invalid("its ImageOrientationPatient is not two perpendicular unit vectors", where);
    }
    if (planes_->images.empty()) return {};
    const DicomImage& first = planes_->images.front();
    for (std::size_t i = 0; i < 6; ++i) {
      if (std::abs((*image.orientation)[i] - (*first.orientation)[i]) <= kSameDirection) continue;
      return invalid(
          fmt::format("its planes lie in another direction than those of {}: number {} "
                      "of its ImageOrientationPatient is {}, not {}; the series is not "
                      "one volume over time",
                      fileOf(first), i + 1, (*image.orientation)[i], (*first.orientation)[i]),
          where);
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const double a = (*image.spacing)[i];
      if (std::abs(a - (*first.spacing)[i]) <= kSameDirection * a) continue;
      return invalid(fmt::format("its PixelSpacing differs from that of {}: {}, not {}, along {}",
                                 fileOf(first), a, (*first.spacing)[i], i == 0 ? "y" : "x"),
                     where);
    }
    return {};
  }

  const DicomImage& at(std::size_t i) const { return planes_->images[i]; }
  double depth(std::size_t i) const { return normal_.dot(*at(i).position); }

  /// Sorts images along the normal of their planes into `slices_`.
  Result<void> findPlaces(Series&) {
    const DicomImage& first = at(0);
    row_ = Eigen::Vector3d(first.orientation->data()).normalized();
    column_ = Eigen::Vector3d(first.orientation->data() + 3).normalized();
    normal_ = row_.cross(column_).normalized();
    std::vector<std::size_t> order(planes_->images.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return depth(i); });
    for (const std::size_t i : order) {
      if (slices_.empty() || depth(i) - depth(slices_.back().front()) > kSamePlace) {
        slices_.emplace_back();
      }
      slices_.back().push_back(i);
    }
    if (slices_.size() == 1) {
      return invalid(fmt::format("is not a volume over time: its images, {} in all, are at one "
                                 "position",
                                 order.size()),
                     where_);
    }
    return checkPlaces();
  }

  /// Slices are equally far apart, on a straight line.
  Result<void> checkPlaces() {
    const Eigen::Vector3d& begin = *at(slices_.front().front()).position;
    const Eigen::Vector3d& end = *at(slices_.back().front()).position;
    step_ = (end - begin) / static_cast<double>(slices_.size() - 1);
    std::vector<double> gaps;
    for (std::size_t i = 1; i < slices_.size(); ++i) {
      gaps.push_back(depth(slices_[i].front()) - depth(slices_[i - 1].front()));
    }
    std::vector<double> sorted = gaps;
    std::ranges::sort(sorted);
    const double usual = sorted[sorted.size() / 2];
    const double tolerance = kUnevenSlices * usual + kSamePlace;
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      if (std::abs(gaps[i] - usual) <= tolerance) continue;
      return invalid(
          fmt::format("is {:.6g} mm from the slice of {}, but other slices are {:.6g} mm "
                      "apart: slices that are not equally far apart cannot be read",
                      gaps[i], fileOf(at(slices_[i].front())), usual),
          fileOf(at(slices_[i + 1].front())));
    }
    for (std::size_t i = 0; i < slices_.size(); ++i) {
      for (const std::size_t image : slices_[i]) {
        const Eigen::Vector3d expected = begin + static_cast<double>(i) * step_;
        const double beside = (*at(image).position - expected).norm();
        if (beside <= tolerance) continue;
        return invalid(fmt::format("is {:.6g} mm beside the line on which the slices of the series "
                                   "are: it is not one volume over time",
                                   beside),
                       fileOf(at(image)));
      }
    }
    return {};
  }

  // Time --------------------------------------------------------------------------------------

  double time(std::size_t image, std::size_t kind) const { return *at(image).times[kind]; }

  bool allHave(std::size_t kind) const {
    return std::ranges::all_of(
        planes_->images, [&](const DicomImage& image) { return image.times[kind].has_value(); });
  }

  bool differ(std::size_t kind) const {
    return std::ranges::any_of(planes_->images, [&](const DicomImage& image) {
      return image.times[kind] != planes_->images.front().times[kind];
    });
  }

  /// Times of frames by the first kind of time that makes frames of the images.
  Result<std::vector<double>> findTimes() {
    if (std::ranges::all_of(slices_, [](const auto& slice) { return slice.size() == 1; })) {
      return invalid(fmt::format("has one frame only, of {} slices; a 4D mesh needs two or more",
                                 slices_.size()),
                     where_);
    }
    std::optional<Error> first;
    for (std::size_t kind = 0; kind < kDicomTimes; ++kind) {
      if (!allHave(kind) || !differ(kind)) continue;
      auto times = timesBy(kind);
      if (times) {
        kind_ = kind;
        return times;
      }
      if (!first) first = times.error();
    }
    if (first) return std::move(*first);
    return invalid(
        "is not a volume over time: nothing that all of its images have says when each was taken "
        "(TriggerTime, TemporalPositionIdentifier, FrameReferenceTime, AcquisitionTime, "
        "ContentTime)",
        where_);
  }

  std::string placeText(std::size_t image) const {
    const Eigen::Vector3d& p = *at(image).position;
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z());
  }

  Result<std::vector<double>> timesBy(std::size_t kind) {
    for (auto& slice : slices_) {
      std::ranges::stable_sort(slice, {}, [&](std::size_t i) { return time(i, kind); });
    }
    if (auto once = checkOnce(kind); !once) return once.error();
    if (auto whole = checkWhole(kind); !whole) return whole.error();
    return meanTimes(kind);
  }

  /// No place has two images at one time.
  Result<void> checkOnce(std::size_t kind) const {
    for (const auto& slice : slices_) {
      for (std::size_t i = 1; i < slice.size(); ++i) {
        if (time(slice[i], kind) > time(slice[i - 1], kind)) continue;
        return invalid(fmt::format("is a second image at the position {} and {} {:.6g}, beside {}",
                                   placeText(slice[i]), kTimeNames[kind], time(slice[i], kind),
                                   fileOf(at(slice[i - 1]))),
                       fileOf(at(slice[i])));
      }
    }
    return {};
  }

  /// Each place has as many images as the others; else says when one lacks.
  Result<void> checkWhole(std::size_t kind) const {
    const auto size = [](const auto& slice) { return slice.size(); };
    const auto& most = *std::ranges::max_element(slices_, {}, size);
    const auto& least = *std::ranges::min_element(slices_, {}, size);
    if (most.size() == least.size()) return {};
    const auto farthest = std::ranges::max_element(most, {}, [&](std::size_t i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const std::size_t j : least) {
        nearest = std::min(nearest, std::abs(time(i, kind) - time(j, kind)));
      }
      return nearest;
    });
    return invalid(
        fmt::format("images at the position {}: {}, at {}: {}; at {} {:.6g} one is missing",
                    placeText(least.front()), least.size(), placeText(most.front()), most.size(),
                    kTimeNames[kind], time(*farthest, kind)),
        where_);
  }

  /// The mean over the places of each frame. Images of a frame must be nearer to it than half the
  /// way to the next.
  Result<std::vector<double>> meanTimes(std::size_t kind) const {
    const std::size_t count = slices_.front().size();
    // From the first on, so that seconds since 1970 keep their fractions.
    const double start = time(slices_.front().front(), kind);
    std::vector<double> means(count);
    for (std::size_t i = 0; i < count; ++i) {
      double sum = 0;
      for (const auto& slice : slices_) sum += time(slice[i], kind) - start;
      means[i] = start + sum / static_cast<double>(slices_.size());
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double before = i > 0 ? means[i] - means[i - 1] : means[1] - means[0];
      const double after = i + 1 < count ? means[i + 1] - means[i] : before;
      const double half = std::min(before, after) / 2;
      for (const auto& slice : slices_) {
        const double off = std::abs(time(slice[i], kind) - means[i]);
        if (off < half) continue;
        return invalid(fmt::format("its {} {:.6g} is {:.6g} from that of frame {}, whose "
                                   "neighbours are {:.6g} away: an image is missing or doubled, "
                                   "or the series is not one volume over time",
                                   kTimeNames[kind], time(slice[i], kind), off, i, 2 * half),
                       fileOf(at(slice[i])));
      }
    }
    return means;
  }

  Result<Volume> volume(std::vector<double> times) {
    Volume volume;
    volume.where = where_;
    volume.order = std::endian::native;
    const DicomLayout& layout = planes_->layout;
    volume.sizes = {layout.columns, layout.rows, slices_.size(), times.size()};
    volume.axes = "xyzt";
    const DicomImage& first = at(slices_.front().front());
    volume.place.col(0) = row_ * (*first.spacing)[1];
    volume.place.col(1) = column_ * (*first.spacing)[0];
    volume.place.col(2) = step_;
    volume.place.col(3) = *first.position;
    volume.space = "LPS";
    volume.lengthUnit = "mm";
    std::vector<DicomImage> sorted;
    for (std::size_t frame = 0; frame < times.size(); ++frame) {
      for (const auto& slice : slices_) sorted.push_back(at(slice[frame]));
    }
    planes_->images = std::move(sorted);
    setScale(volume);
    setTimes(volume, std::move(times));
    if (inverted_) {
      volume.notice += fmt::format(
          "{}its samples are shown inverted (MONOCHROME1); they are taken "
          "as they are stored",
          volume.notice.empty() ? "" : "; ");
    }
    SampleData data;
    data.path = where_;
    data.encoding = SampleEncoding::Dicom;
    data.dicom = std::move(planes_);
    volume.data = {std::move(data)};
    return volume;
  }

  void setScale(Volume& volume) const {
    const DicomImage& first = at(0);
    planes_->scaled = std::ranges::any_of(planes_->images, [&](const DicomImage& image) {
      return image.slope != first.slope || image.intercept != first.intercept;
    });
    volume.type = planes_->scaled ? SampleType::Float32 : planes_->layout.type();
    if (!planes_->scaled) {
      volume.slope = first.slope;
      volume.intercept = first.intercept;
    }
  }

  void setTimes(Volume& volume, std::vector<double> times) const {
    const auto kind = static_cast<DicomTime>(kind_);
    if (kind == DicomTime::TemporalPosition) return;  // numbers only: frames are 1 apart
    // Times of day begin with the first image.
    const double start =
        kind == DicomTime::Acquisition || kind == DicomTime::Content ? times.front() : 0;
    for (double& time : times) time -= start;
    volume.startTime = times.front();
    volume.timeUnit = "s";
    volume.times = std::move(times);
  }

  std::string where_;
  std::shared_ptr<DicomPlanes> planes_ = std::make_shared<DicomPlanes>();
  bool inverted_ = false;
  std::size_t kind_ = 0;
  Eigen::Vector3d row_, column_, normal_, step_;
  std::vector<std::vector<std::size_t>> slices_;  // numbers of images, by place and then by time
};

}  // namespace

bool isDicom(const fs::path& path) {
  std::error_code problem;
  if (!fs::is_directory(path, problem)) return hasDicomSignature(path);
  bool found = false;
  for (const auto& entry : fs::directory_iterator(path, problem)) {
    if (entry.path().extension() == ".vdb") return false;
    found = found || hasDicomSignature(entry.path());
  }
  return found;
}

Result<Volume> readDicomSeries(std::span<const fs::path> inputs, const std::string& series) {
  auto files = filesOf(inputs);
  if (!files) return files.error();
  const std::string where = inputs.front().string();
  std::map<std::string, Series> all;
  for (const fs::path& path : *files) {
    auto file = readDicomFile(path);
    if (!file) return file.error();
    Series& one = all[file->series];
    one.number = file->number;
    one.description = file->description;
    one.files.push_back(path);
    one.contents.push_back(std::move(*file));
  }
  if (all.empty()) return invalid("is a folder that holds no DICOM images", where);
  auto chosen = choose(std::move(all), series, where);
  if (!chosen) return chosen.error();
  return Arrangement(where).arrange(std::move(*chosen));
}

}  // namespace t4d::voxel4d
