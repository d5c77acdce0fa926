#include "formats/mesh4d/medit_binary_reader.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "formats/mesh4d/mesh4d_builder.h"
#include "formats/text/byte_scanner.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kMeditHeaderBytes = 8;  // a 1, in the file's byte order, and the version

/// Numbers of libMeshb's keywords.
enum MeditKeyword : std::int32_t {
  kMeditDimension = 3,
  kMeditVertices = 4,
  kMeditTetrahedra = 8,
  kMeditEnd = 54,
};

/// Keywords of other elements, whose loss is worth a line.
struct OtherElements {
  std::int32_t keyword;
  std::string_view name;
};
constexpr std::array kOtherElements = {
    OtherElements{5, "Edges"},  OtherElements{6, "Triangles"},  OtherElements{7, "Quadrilaterals"},
    OtherElements{9, "Prisms"}, OtherElements{10, "Hexahedra"}, OtherElements{49, "Pyramids"},
};

std::endian orderOf(std::string_view begin) {
  return loadNumber<std::int32_t>(begin.data()) == 1 ? std::endian::little : std::endian::big;
}

class MeditBinaryReader {
 public:
  explicit MeditBinaryReader(const InputFile& file)
      : file_(file),
        bytes_(file, kMeditHeaderBytes, orderOf(file.bytes)),
        version_(loadNumber<std::int32_t>(file.bytes.data() + 4, orderOf(file.bytes))),
        mesh_(
            file.path.string(), [&file](auto offset) { return file.atByte(offset); }, 1) {}

  Result<LoadedMesh4d> read() {
    for (bool more = true; more;) {
      auto found = readKeyword();
      if (!found) return found.error();
      more = *found;
    }
    if (!dimension_) return bytes_.invalidHere("has no dimension");
    auto loaded = std::move(mesh_).finish();
    if (!loaded) return loaded;
    loaded->dialect = fmt::format("version {}", version_);
    if (orderOf(file_.bytes) == std::endian::big) loaded->dialect += ", big-endian";
    loaded->losses = std::move(losses_);
    return loaded;
  }

 private:
  bool hasWidePositions() const { return version_ >= 3; }
  bool hasWideIntegers() const { return version_ >= 4; }
  bool hasDoubles() const { return version_ >= 2; }

  std::int64_t nextInteger() {
    return hasWideIntegers() ? bytes_.next<std::int64_t>() : bytes_.next<std::int32_t>();
  }
  std::size_t integerBytes() const { return hasWideIntegers() ? 8 : 4; }

  /// Reads a keyword with all that is its; false at the end.
  Result<bool> readKeyword() {
    const std::size_t begin = bytes_.at();
    const auto keyword = bytes_.number<std::int32_t>("a keyword, or End (54)");
    if (!keyword) return keyword.error();
    // Some writers put no offset after it.
    if (*keyword == kMeditEnd) return false;
    const auto next = hasWidePositions() ? bytes_.number<std::int64_t>("the offset of a keyword")
                                         : narrowPosition();
    if (!next) return next.error();
    if (*next <= static_cast<std::int64_t>(bytes_.at()) ||
        *next > static_cast<std::int64_t>(file_.bytes.size())) {
      return invalid(fmt::format("the keyword {} is followed by one at byte {}, expected {} to {}",
                                 *keyword, *next, bytes_.at() + 1, file_.bytes.size()),
                     file_.atByte(begin));
    }
    Result<void> done;
    if (*keyword == kMeditDimension) {
      done = readDimension();
    } else if (*keyword == kMeditVertices) {
      done = readVertices();
    } else if (*keyword == kMeditTetrahedra) {
      done = readTetrahedra();
    } else {
      done = noteLoss(*keyword);
      bytes_.goTo(static_cast<std::size_t>(*next));
    }
    if (!done) return done.error();
    if (bytes_.at() != static_cast<std::size_t>(*next)) {
      return bytes_.invalidHere(
          fmt::format("the elements of keyword {} end here, but the next keyword is at byte {}",
                      *keyword, *next));
    }
    return true;
  }

  Result<std::int64_t> narrowPosition() {
    const auto position = bytes_.number<std::uint32_t>("the offset of a keyword");
    if (!position) return position.error();
    return std::int64_t{*position};
  }

  Result<void> readDimension() {
    const auto dimension = bytes_.number<std::int32_t>("the dimension, 4");
    if (!dimension) return dimension.error();
    if (*dimension != 4) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("is a mesh of dimension {}, expected 4", *dimension),
                  file_.atByte(bytes_.at() - 4));
    }
    dimension_ = true;
    return {};
  }

  Result<std::uint64_t> readCount() {
    if (auto good = bytes_.checkLeft(1, integerBytes(), "a count"); !good) {
      return good.error();
    }
    const std::int64_t count = nextInteger();
    if (count >= 0) return static_cast<std::uint64_t>(count);
    return invalid(fmt::format("the count is {}, expected 0 or more", count),
                   file_.atByte(bytes_.at() - integerBytes()));
  }

  Result<void> noteLoss(std::int32_t keyword) {
    const auto* other = std::ranges::find(kOtherElements, keyword, &OtherElements::keyword);
    if (other == kOtherElements.end()) return {};
    const auto count = readCount();
    if (!count) return count.error();
    if (*count > 0) {
      losses_.push_back(
          fmt::format("{}: '{}' '{}' are not read", file_.path.string(), *count, other->name));
    }
    return {};
  }

  Result<void> readVertices() {
    if (!dimension_) return bytes_.invalidHere("vertices come before the dimension");
    const auto count = readCount();
    if (!count) return count.error();
    const std::size_t each = 4 * (hasDoubles() ? 8 : 4) + integerBytes();
    if (auto good = bytes_.checkCount(*count, each, "vertices"); !good) return good;
    for (std::uint64_t i = 0; i < *count; ++i) {
      const std::size_t place = bytes_.at();
      model::Point4 vertex;
      for (double& coordinate : vertex) {
        coordinate = hasDoubles() ? bytes_.next<double>() : bytes_.next<float>();
      }
      nextInteger();  // the reference of a vertex
      if (auto added = mesh_.addVertex(vertex, place); !added) return added;
    }
    return {};
  }

  Result<void> readTetrahedra() {
    const auto count = readCount();
    if (!count) return count.error();
    if (auto good = bytes_.checkCount(*count, 5 * integerBytes(), "tetrahedra"); !good) return good;
    for (std::uint64_t i = 0; i < *count; ++i) {
      const std::size_t place = bytes_.at();
      std::array<std::uint64_t, 4> corners{};
      for (std::uint64_t& corner : corners) {
        const std::int64_t number = nextInteger();
        if (number < 1) {
          return invalid(fmt::format("found vertex {}, expected 1 or more", number),
                         file_.atByte(bytes_.at() - integerBytes()));
        }
        corner = static_cast<std::uint64_t>(number) - 1;
      }
      const std::int64_t reference = nextInteger();
      if (auto added = mesh_.addCell(corners, reference, place); !added) return added;
    }
    return {};
  }

  const InputFile& file_;
  ByteScanner bytes_;
  std::int32_t version_;
  Mesh4dBuilder mesh_;
  bool dimension_ = false;
  std::vector<std::string> losses_;
};

}  // namespace

bool isMeditBinary(std::string_view begin) {
  if (begin.size() < kMeditHeaderBytes) return false;
  return std::ranges::any_of(std::array{std::endian::little, std::endian::big}, [&](auto order) {
    const auto version = loadNumber<std::int32_t>(begin.data() + 4, order);
    return loadNumber<std::int32_t>(begin.data(), order) == 1 && version >= 1 && version <= 4;
  });
}

Result<LoadedMesh4d> readMeditBinary(const InputFile& file) {
  if (isMeditBinary(file.bytes)) return MeditBinaryReader(file).read();
  return invalid("does not begin with a 1 and a version, 1 to 4, of 4 bytes each", file.atByte(0));
}

}  // namespace t4d::formats
