#include "voxel4d/volumes/volume_samples.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

namespace t4d::voxel4d {
namespace {

constexpr std::array<int, 4> kSizes = {5, 4, 6, 2};  // x, y, z, t

/// Values with the axes in this order, the first fastest.
std::vector<float> values(const std::string& axes) {
  std::vector<float> all;
  std::array<int, 4> at{};  // x, y, z, t
  const auto axis = [&](int i) { return axes[i] == 't' ? 3 : axes[i] - 'x'; };
  const auto next = [&] {
    for (int i = 0; i < 4; ++i) {
      if (++at[axis(i)] < kSizes[axis(i)]) return true;
      at[axis(i)] = 0;
    }
    return false;
  };
  do all.push_back(volumeSample(at[0], at[1], at[2], at[3]));
  while (next());
  return all;
}

template <class T>
std::string bytesOf(T value, std::endian order = std::endian::little) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (order != std::endian::native) std::ranges::reverse(bytes);
  return bytes;
}

template <class T>
std::string bytesOf(const std::vector<T>& values, std::endian order = std::endian::little) {
  std::string bytes;
  for (const T value : values) bytes += bytesOf(value, order);
  return bytes;
}

std::string nrrd(const std::string& encoding, const std::string& endian,
                 const std::string& dataFile = "") {
  return "NRRD0004\n# a ball\ntype: float\ndimension: 4\nsizes: 5 4 6 2\n"
         "space: left-posterior-superior\n"
         "space directions: (0.5,0,0) (0,0.5,0) (0, 0, 0.5) none\nspace origin: (-1,2,0.25)\n"
         "kinds: space space space time\nspacings: nan nan nan 0.25\nspace units: \"mm\" \"mm\" "
         "\"mm\"\nendian: " +
         endian + "\nencoding: " + encoding + "\n" + dataFile + "\n";
}

std::string npy(const std::string& order, const std::string& shape, char endian) {
  std::string header = fmt::format("{{'descr': '{}f4', 'fortran_order': {}, 'shape': ({}), }}",
                                   endian, order, shape);
  header.resize(117, ' ');
  return "\x93NUMPY" + std::string("\1\0", 2) + bytesOf(std::uint16_t{118}) + header + "\n";
}

class Header {
 public:
  Header(std::size_t size, std::endian order) : bytes_(size, '\0'), order_(order) {}
  template <class T>
  Header& put(std::size_t at, std::vector<T> values) {
    const std::string bytes = bytesOf(values, order_);
    bytes_.replace(at, bytes.size(), bytes);
    return *this;
  }
  Header& text(std::size_t at, std::string_view text) {
    bytes_.replace(at, text.size(), text);
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::endian order_;
};

std::string nifti1(std::endian order, std::string_view magic) {
  return Header(352, order)
      .put<std::int32_t>(0, {348})
      .put<std::int16_t>(40, {4, 5, 4, 6, 2, 1, 1, 1})
      .put<std::int16_t>(70, {16, 32})
      .put<float>(76, {1, 0.5F, 0.5F, 0.5F, 0.25F, 0, 0, 0})
      .put<float>(108, {magic == "n+1" ? 352.0F : 0.0F})
      .text(123, "\x0A")
      .put<std::int16_t>(252, {0, 1})
      .put<float>(280, {0.5F, 0, 0, -1, 0, 0.5F, 0, 2, 0, 0, 0.5F, 0.25F})
      .text(344, magic)
      .bytes();
}

/// Placed by a quaternion, which does not turn.
std::string nifti2(std::endian order) {
  return Header(544, order)
      .put<std::int32_t>(0, {540})
      .text(4, {"n+2\0\r\n\x1a\n", 8})
      .put<std::int16_t>(12, {16, 32})
      .put<std::int64_t>(16, {4, 5, 4, 6, 2, 1, 1, 1})
      .put<double>(104, {1, 0.5, 0.5, 0.5, 0.25, 0, 0, 0})
      .put<std::int64_t>(168, {544})
      .put<std::int32_t>(344, {1, 0})
      .put<double>(376, {-1, 2, 0.25})
      .put<std::int32_t>(500, {2 | 8})
      .bytes();
}

}  // namespace

std::string gzipped(const std::string& bytes) {
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS;
  deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

float volumeSample(int x, int y, int z, int frame) {
  return static_cast<float>(std::hypot(x - 1.9 - 0.3 * frame, y - 1.6, z - 2.4 + 0.1 * frame) -
                            1.45);
}

std::map<std::string, std::string> volumeSamples() {
  constexpr std::endian kLittle = std::endian::little;
  constexpr std::endian kBig = std::endian::big;
  const std::vector<float> xyzt = values("xyzt");
  const std::string little = bytesOf(xyzt, kLittle);
  const std::string big = bytesOf(xyzt, kBig);
  const std::size_t half = little.size() / 2;
  std::string text;
  for (const float value : xyzt) text += fmt::format("{} ", value);
  return {
      {"raw.nrrd", nrrd("raw", "little") + little},
      {"gzip.nrrd", nrrd("gzip", "big") + gzipped(big)},
      {"text.nrrd", nrrd("text", "little") + text},
      {"pattern.nhdr", nrrd("raw", "little", "data file: f%02d.raw 1 2 1\n")},
      {"list.nhdr", nrrd("raw", "little", "data file: LIST\nf01.raw\nf02.raw")},
      {"list_time.nrrd",
       "NRRD0005\r\ntype: float\r\ndimension: 4\r\nsizes: 2 5 4 6\r\nspace dimension: 3\r\n"
       "space directions: none (0.5,0,0) (0,0.5,0) (0,0,0.5)\r\nspace origin: (-1,2,0.25)\r\n"
       "kinds: list domain domain domain\r\nendian: little\r\nencoding: raw\r\n\r\n" +
           bytesOf(values("txyz"))},
      {"f01.raw", little.substr(0, half)},
      {"f02.raw", little.substr(half)},
      {"c.npy", npy("False", "2, 5, 4, 6", '<') + bytesOf(values("zyxt"))},
      {"fortran.npy", npy("True", "2, 5, 4, 6", '>') + bytesOf(values("txyz"), kBig)},
      {"one.nii", nifti1(kLittle, "n+1") + little},
      {"one_big.nii.gz", gzipped(nifti1(kBig, "n+1") + big)},
      {"pair.hdr", nifti1(kLittle, "ni1")},
      {"pair.img", little},
      {"two.nii", nifti2(kLittle) + little},
      {"two_big.nii", nifti2(kBig) + big},
      {"line.raw", "raw float32 5 4 6 2 big\n" + big},
  };
}

}  // namespace t4d::voxel4d
