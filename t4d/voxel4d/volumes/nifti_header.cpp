#include <algorithm>
#include <cmath>
#include <cstring>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <zlib.h>

#include "t4d/voxel4d/volumes/header_text.h"
#include "t4d/voxel4d/volumes/headers.h"

namespace t4d::voxel4d {
namespace {

/// Where the fields of a header are, in bytes.
struct Layout {
  bool second;  // NIfTI-2: sizes of 64 bits, floats of 64 bits
  int dim, datatype, pixdim, offset, slope, units, qform, quaternion, shift, srow, toffset, magic;
};
constexpr Layout kFirst = {false, 40, 70, 76, 108, 112, 123, 252, 256, 268, 280, 136, 344};
constexpr Layout kSecond = {true, 16, 12, 104, 168, 176, 500, 344, 352, 376, 400, 216, 4};
constexpr std::size_t kFirstBytes = 348;
constexpr std::size_t kSecondBytes = 540;

class Fields {
 public:
  Fields(const std::array<char, kSecondBytes>& bytes, const Layout& layout, bool swapped)
      : bytes_(bytes), layout_(layout), swapped_(swapped) {}

  template <class T>
  T at(int offset) const {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes_.data() + offset, sizeof(T));
    if (swapped_) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
  /// Number i of an array of floats, or doubles.
  double real(int offset, int i = 0) const {
    return layout_.second ? at<double>(offset + 8 * i)
                          : static_cast<double>(at<float>(offset + 4 * i));
  }
  std::int64_t dim(int i) const {
    return layout_.second ? at<std::int64_t>(layout_.dim + 8 * i)
                          : at<std::int16_t>(layout_.dim + 2 * i);
  }
  /// A code of 16 bits, or 32.
  int code(int offset, int i = 0) const {
    return layout_.second ? at<std::int32_t>(offset + 4 * i) : at<std::int16_t>(offset + 2 * i);
  }

 private:
  const std::array<char, kSecondBytes>& bytes_;
  const Layout& layout_;
  bool swapped_;
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
model::Affine3x4 placeOf(const Fields& fields, const Layout& layout) {
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

}  // namespace

Result<Volume> readNiftiHeader(const std::filesystem::path& path) {
  Volume volume;
  volume.where = path.string();
  std::array<char, kSecondBytes> bytes{};
  if (auto there = openHeader(path); !there) return there.error();
  // Reads what is not compressed as well.
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) return fail(ErrorCode::Io, "cannot open", volume.where);
  const int got = gzread(file, bytes.data(), bytes.size());
  const bool packed = gzdirect(file) == 0;
  gzclose(file);
  if (got == 0) return invalid("is empty", volume.where);
  if (got < static_cast<int>(kFirstBytes)) {
    return invalid("is not a NIfTI file: it is shorter than a header", volume.where);
  }
  std::int32_t headerBytes = 0;
  std::memcpy(&headerBytes, bytes.data(), sizeof headerBytes);
  const auto swappedBytes =
      static_cast<std::int32_t>(__builtin_bswap32(static_cast<std::uint32_t>(headerBytes)));
  const auto is = [&](std::size_t size) {
    return headerBytes == static_cast<std::int32_t>(size) ||
           swappedBytes == static_cast<std::int32_t>(size);
  };
  const Layout& layout = is(kSecondBytes) ? kSecond : kFirst;
  const std::string_view magic(bytes.data() + layout.magic, 3);
  const bool single = magic == (layout.second ? "n+2" : "n+1");
  const bool pair = magic == (layout.second ? "ni2" : "ni1");
  if (!(is(kFirstBytes) || is(kSecondBytes)) || !(single || pair) ||
      got < static_cast<int>(layout.second ? kSecondBytes : kFirstBytes)) {
    return invalid(
        "is not a NIfTI file: size and magic of its header are neither those of version "
        "1 nor 2",
        volume.where);
  }
  const bool swapped = !(headerBytes == static_cast<std::int32_t>(kFirstBytes) ||
                         headerBytes == static_cast<std::int32_t>(kSecondBytes));
  volume.order = swapped == (std::endian::native == std::endian::little) ? std::endian::big
                                                                         : std::endian::little;
  const Fields fields(bytes, layout, swapped);

  const int code = fields.at<std::int16_t>(layout.datatype);
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
  volume.place = placeOf(fields, layout);
  // Where both codes are 0, the standard says nothing of directions.
  if (fields.code(layout.qform) > 0 || fields.code(layout.qform, 1) > 0) volume.space = "RAS";

  const double slope = fields.real(layout.slope);
  if (std::isfinite(slope) && slope != 0) {
    volume.slope = slope;
    volume.intercept = fields.real(layout.slope, 1);
  }
  const int units = layout.second ? fields.at<std::int32_t>(layout.units)
                                  : static_cast<unsigned char>(bytes[layout.units]);
  switch (units & 7) {
    case 1:
      volume.lengthUnit = "m";
      break;
    case 2:
      volume.lengthUnit = "mm";
      break;
    case 3:
      volume.lengthUnit = "um";
      break;
    default:
      break;
  }
  switch (units & 56) {
    case 8:
      volume.timeUnit = "s";
      break;
    case 16:
      volume.timeUnit = "ms";
      break;
    case 24:
      volume.timeUnit = "us";
      break;
    case 32:
    case 40:
    case 48:
      if (volume.frames() == 1) break;
      return fail(ErrorCode::Unsupported,
                  fmt::format("its fourth axis is not the time: its unit is {}",
                              (units & 56) == 32   ? "hertz"
                              : (units & 56) == 40 ? "parts per million"
                                                   : "radians per second"),
                  volume.where);
    default:
      break;
  }
  const double step = fields.real(layout.pixdim, 4);
  if (std::isfinite(step) && step > 0) volume.frameTime = step;
  const double start = fields.real(layout.toffset);
  if (std::isfinite(start)) volume.startTime = start;

  SampleData data{path};
  data.mayHaveMore = true;
  const double offset = layout.second ? static_cast<double>(fields.at<std::int64_t>(layout.offset))
                                      : fields.real(layout.offset);
  const double least = single ? static_cast<double>(layout.second ? kSecondBytes : kFirstBytes) : 0;
  constexpr double kMost = 1e9;
  if (!(offset >= least && offset <= kMost)) {
    return invalid(fmt::format("says that its samples begin at byte {}", offset), volume.where);
  }
  if (pair) {
    data.path.replace_extension();  // .hdr, or .gz of .hdr.gz
    if (data.path.extension() == ".hdr") data.path.replace_extension();
    data.path += ".img";
    std::error_code ignored;
    const std::filesystem::path plain = data.path;
    if (!std::filesystem::exists(plain, ignored)) {
      data.path += ".gz";
      if (!std::filesystem::exists(data.path, ignored)) {
        return fail(ErrorCode::Io,
                    fmt::format("its samples are missing: there is neither {} nor {}",
                                plain.string(), data.path.string()),
                    volume.where);
      }
    }
    if (auto within = checkDataFile(volume.where, data.path); !within) return within.error();
    data.encoding = data.path.extension() == ".gz" ? SampleEncoding::Gzip : SampleEncoding::Raw;
  } else {
    data.encoding = packed ? SampleEncoding::Gzip : SampleEncoding::Raw;
  }
  data.begin = static_cast<std::uint64_t>(offset);
  volume.data = {data};
  return volume;
}

}  // namespace t4d::voxel4d
