#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <zlib.h>

#include "voxel4d/volumes/header_text.h"
#include "voxel4d/volumes/headers.h"

namespace t4d::voxel4d {
namespace {

/// The offsets of the fields of a header, in bytes.
struct Layout {
  bool second;  // NIfTI-2: sizes of 64 bits, floats of 64 bits
  int dim, datatype, pixdim, offset, slope, units, qform, quaternion, shift, srow, toffset, magic;
};
constexpr Layout kFirst = {false, 40, 70, 76, 108, 112, 123, 252, 256, 268, 280, 136, 344};
constexpr Layout kSecond = {true, 16, 12, 104, 168, 176, 500, 344, 352, 376, 400, 216, 4};
constexpr std::size_t kFirstBytes = 348;
constexpr std::size_t kSecondBytes = 540;

/// The header of a file, whose numbers are read in the file's byte order.
struct NiftiFields {
  std::array<char, kSecondBytes> bytes{};
  Layout layout = kFirst;
  bool swapped = false;  ///< its numbers are in the other byte order than the machine's
  bool packed = false;   ///< the file is compressed
  bool pair = false;     ///< samples are in another file

  std::size_t size() const { return layout.second ? kSecondBytes : kFirstBytes; }

  template <class T>
  T at(int offset) const {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes.data() + offset, sizeof(T));
    if (swapped) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
  /// Number i of an array of floats, or doubles.
  double real(int offset, int i = 0) const {
    return layout.second ? at<double>(offset + 8 * i)
                         : static_cast<double>(at<float>(offset + 4 * i));
  }
  std::int64_t dim(int i) const {
    return layout.second ? at<std::int64_t>(layout.dim + 8 * i)
                         : at<std::int16_t>(layout.dim + 2 * i);
  }
  /// A code of 16 bits, or 32.
  int code(int offset, int i = 0) const {
    return layout.second ? at<std::int32_t>(offset + 4 * i) : at<std::int16_t>(offset + 2 * i);
  }
};

std::optional<SampleType> typeOf(int code) {
  switch (code) {
    case 2:
      return SampleType::UInt8;
    case 4:
      return SampleType::Int16;
    case 8:
      return SampleType::Int32;
    case 16:
      return SampleType::Float32;
    case 64:
      return SampleType::Float64;
    case 256:
      return SampleType::Int8;
    case 512:
      return SampleType::UInt16;
    case 768:
      return SampleType::UInt32;
    case 1024:
      return SampleType::Int64;
    case 1280:
      return SampleType::UInt64;
    default:
      return std::nullopt;
  }
}

/// NIfTI's three ways to say where voxels are; the first that is there.
model::Affine3x4 placeOf(const NiftiFields& fields) {
  const Layout& layout = fields.layout;
  model::Affine3x4 place = model::Affine3x4::Identity();
  const int sform = fields.code(layout.qform, 1);
  if (sform > 0) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        place(row, column) = fields.real(layout.srow, 4 * row + column);
      }
    }
    return place;
  }
  const Eigen::Vector3d size(std::abs(fields.real(layout.pixdim, 1)),
                             std::abs(fields.real(layout.pixdim, 2)),
                             std::abs(fields.real(layout.pixdim, 3)));
  if (fields.code(layout.qform) > 0) {
    const Eigen::Vector3d xyz(fields.real(layout.quaternion, 0), fields.real(layout.quaternion, 1),
                              fields.real(layout.quaternion, 2));
    const double w = std::sqrt(std::max(0.0, 1 - xyz.squaredNorm()));
    const Eigen::Quaterniond turn(w, xyz[0], xyz[1], xyz[2]);
    place.leftCols<3>() = turn.normalized().toRotationMatrix() * size.asDiagonal();
    if (fields.real(layout.pixdim, 0) < 0) place.col(2) *= -1;  // qfac
    for (int axis = 0; axis < 3; ++axis) place(axis, 3) = fields.real(layout.shift, axis);
    return place;
  }
  place.leftCols<3>() = size.asDiagonal();
  return place;
}

Result<NiftiFields> readNiftiFields(const std::filesystem::path& path) {
  NiftiFields fields;
  if (auto there = openHeader(path); !there) return there.error();
  // Reads what is not compressed as well.
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) return fail(ErrorCode::Io, "cannot open", path);
  const int got = gzread(file, fields.bytes.data(), fields.bytes.size());
  fields.packed = gzdirect(file) == 0;
  gzclose(file);
  if (got == 0) return invalid("is empty", path);
  if (got < static_cast<int>(kFirstBytes)) {
    return invalid("is not a NIfTI file: it is shorter than a header", path);
  }
  std::uint32_t size = 0;
  std::memcpy(&size, fields.bytes.data(), sizeof size);
  fields.swapped = size != kFirstBytes && size != kSecondBytes;
  if (fields.swapped) size = __builtin_bswap32(size);
  if (size == kSecondBytes) fields.layout = kSecond;
  const bool second = fields.layout.second;
  const std::string_view magic(fields.bytes.data() + fields.layout.magic, 3);
  fields.pair = magic == (second ? "ni2" : "ni1");
  const bool single = magic == (second ? "n+2" : "n+1");
  if (size != fields.size() || !(single || fields.pair) || std::cmp_less(got, size)) {
    return invalid(
        "is not a NIfTI file: size and magic of its header are neither those of version "
        "1 nor 2",
        path);
  }
  return fields;
}

/// The type and number of the samples along each axis.
Result<void> takeNiftiSamples(const NiftiFields& fields, Volume& volume) {
  const int code = fields.at<std::int16_t>(fields.layout.datatype);
  const auto type = typeOf(code);
  if (!type) {
    return invalid(fmt::format("has samples of NIfTI's type {}; integers, and floats of 32 and 64 "
                               "bits can be used",
                               code),
                   volume.where);
  }
  volume.type = *type;
  const std::int64_t axes = fields.dim(0);
  if (axes < 3 || axes > 7) {
    return invalid(fmt::format("has {} axes; expected three or four", axes), volume.where);
  }
  for (int i = 1; i <= axes; ++i) {
    const std::int64_t size = fields.dim(i);
    if (size < 1 || (i > 4 && size != 1)) {
      return invalid(fmt::format("has {} samples along axis {}; expected {}", size, i,
                                 i > 4 ? "1, for samples are single numbers" : "1 or more"),
                     volume.where);
    }
    if (i <= 4) volume.sizes.push_back(static_cast<std::uint64_t>(size));
  }
  volume.axes = std::string("xyzt").substr(0, volume.sizes.size());
  const double slope = fields.real(fields.layout.slope);
  if (std::isfinite(slope) && slope != 0) {
    volume.slope = slope;
    volume.intercept = fields.real(fields.layout.slope, 1);
  }
  return {};
}

/// The units, and the times of several frames. Fails if the fourth axis is not the time.
Result<void> takeNiftiTimes(const NiftiFields& fields, Volume& volume) {
  const int units = fields.layout.second
                        ? fields.at<std::int32_t>(fields.layout.units)
                        : static_cast<unsigned char>(fields.bytes[fields.layout.units]);
  constexpr std::array<const char*, 4> kLengths = {"", "m", "mm", "um"};
  constexpr std::array<const char*, 4> kTimes = {"", "s", "ms", "us"};
  constexpr std::array<const char*, 3> kOthers = {"hertz", "parts per million",
                                                  "radians per second"};
  const auto length = static_cast<std::size_t>(units & 7);
  const auto time = static_cast<std::size_t>(units >> 3 & 7);
  if (length < kLengths.size()) volume.lengthUnit = kLengths[length];
  // pixdim[4] and the unit are of the fourth axis; programs leave anything in them without one.
  if (volume.frames() == 1) return {};
  if (time < kTimes.size()) {
    volume.timeUnit = kTimes[time];
  } else if (time - kTimes.size() < kOthers.size()) {
    return fail(ErrorCode::Unsupported,
                fmt::format("its fourth axis is not the time: its unit is {}",
                            kOthers[time - kTimes.size()]),
                volume.where);
  }
  const double step = fields.real(fields.layout.pixdim, 4);
  if (std::isfinite(step) && step > 0) volume.frameTime = step;
  const double start = fields.real(fields.layout.toffset);
  if (std::isfinite(start)) volume.startTime = start;
  return {};
}

/// Where the samples are: in the same file, or in an .img beside it.
Result<SampleData> niftiDataOf(const NiftiFields& fields, const std::filesystem::path& path) {
  SampleData data{path};
  data.mayHaveMore = true;
  const Layout& layout = fields.layout;
  const double offset = layout.second ? static_cast<double>(fields.at<std::int64_t>(layout.offset))
                                      : fields.real(layout.offset);
  const double least = fields.pair ? 0 : static_cast<double>(fields.size());
  constexpr double kMost = 1e9;
  if (!(offset >= least && offset <= kMost)) {
    return invalid(fmt::format("says that its samples begin at byte {}", offset), path);
  }
  data.begin = static_cast<std::uint64_t>(offset);
  data.encoding = fields.packed ? SampleEncoding::Gzip : SampleEncoding::Raw;
  if (!fields.pair) return data;
  data.path.replace_extension();  // .hdr, or .gz of .hdr.gz
  if (data.path.extension() == ".hdr") data.path.replace_extension();
  data.path += ".img";
  std::error_code ignored;
  const std::filesystem::path plain = data.path;
  if (!std::filesystem::exists(plain, ignored)) {
    data.path += ".gz";
    if (!std::filesystem::exists(data.path, ignored)) {
      return fail(ErrorCode::Io,
                  fmt::format("its samples are missing: there is neither {} nor {}", plain.string(),
                              data.path.string()),
                  path);
    }
  }
  if (auto within = checkDataFile(path.string(), data.path); !within) return within.error();
  data.encoding = data.path.extension() == ".gz" ? SampleEncoding::Gzip : SampleEncoding::Raw;
  return data;
}

}  // namespace

Result<Volume> readNiftiHeader(const std::filesystem::path& path) {
  const auto fields = readNiftiFields(path);
  if (!fields) return fields.error();
  Volume volume;
  volume.where = path.string();
  volume.order = fields->swapped == (std::endian::native == std::endian::little)
                     ? std::endian::big
                     : std::endian::little;
  if (auto taken = takeNiftiSamples(*fields, volume); !taken) return taken.error();
  volume.place = placeOf(*fields);
  // Where both codes are 0, the standard says nothing of directions.
  const int qform = fields->layout.qform;
  if (fields->code(qform) > 0 || fields->code(qform, 1) > 0) volume.space = "RAS";
  if (auto taken = takeNiftiTimes(*fields, volume); !taken) return taken.error();
  auto data = niftiDataOf(*fields, path);
  if (!data) return data.error();
  volume.data = {std::move(*data)};
  return volume;
}

}  // namespace t4d::voxel4d
