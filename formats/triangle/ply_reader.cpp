#include "formats/triangle/ply_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include <fmt/format.h>

#include "formats/text/text_scanner.h"
#include "formats/triangle/mesh_builder.h"
#include "formats/triangle/ply_header.h"

namespace t4d::formats {
namespace {

/// The rows of text data, one per line.
class TextRows {
 public:
  TextRows(const InputFile&, TextScanner& scanner) : scanner_(scanner) {}

  static std::size_t leastBytes(PlyType) { return 2; }  // a digit and what separates it
  std::size_t bytesLeft() const { return scanner_.bytesLeft() + 1; }
  std::uint64_t place() const { return scanner_.line(); }
  Place where() const { return scanner_.where(); }
  const Error& error() const { return scanner_.error(); }

  bool nextRow() { return scanner_.nextLine(); }
  bool next(PlyType, double& value, const char* what) { return scanner_.number(value, what); }
  Result<void> endRow() {
    if (!scanner_.hasWord()) return {};
    return scanner_.unexpectedWord(scanner_.word(), "the end of the line");
  }

 private:
  TextScanner& scanner_;
};

/// The rows of binary data, without separators.
class BinaryRows {
 public:
  BinaryRows(const InputFile& file, TextScanner& scanner, std::endian order)
      : file_(file), order_(order), at_(scanner.skipLineBreak()) {}

  static std::size_t leastBytes(PlyType type) { return plySize(type); }
  std::size_t bytesLeft() const { return file_.bytes.size() - at_; }
  std::uint64_t place() const { return at_; }
  Place where() const { return file_.atByte(at_); }
  const Error& error() const { return error_; }

  bool nextRow() { return true; }
  bool next(PlyType type, double& value, const char* what) {
    if (bytesLeft() < plySize(type)) {
      error_ = {ErrorCode::InvalidInput, fmt::format("the file ends, expected {}", what), where()};
      return false;
    }
    value = load(type, file_.bytes.data() + at_);
    at_ += plySize(type);
    return true;
  }
  Result<void> endRow() { return {}; }

 private:
  double load(PlyType type, const char* from) const {
    switch (type) {
      case PlyType::Int8:
        return loadNumber<std::int8_t>(from, order_);
      case PlyType::UInt8:
        return loadNumber<std::uint8_t>(from, order_);
      case PlyType::Int16:
        return loadNumber<std::int16_t>(from, order_);
      case PlyType::UInt16:
        return loadNumber<std::uint16_t>(from, order_);
      case PlyType::Int32:
        return loadNumber<std::int32_t>(from, order_);
      case PlyType::UInt32:
        return loadNumber<std::uint32_t>(from, order_);
      case PlyType::Float32:
        return loadNumber<float>(from, order_);
      case PlyType::Float64:
        return loadNumber<double>(from, order_);
    }
    return 0;
  }

  const InputFile& file_;
  std::endian order_;
  std::size_t at_;
  Error error_;
};

template <class Rows>
class PlyReader {
 public:
  PlyReader(const InputFile& file, Rows rows, MeshBuilder::PlaceOf placeOf)
      : rows_(std::move(rows)), builder_(file.path.string(), std::move(placeOf)) {}

  Result<LoadedMesh> read(const PlyHeader& header, Keep keep) {
    for (const PlyElement& element : header.elements) {
      if (element.name == "vertex" && keep == Keep::Attributes) findLooks(element);
      if (auto done = readElement(element); !done) return done.error();
    }
    FileCorners corners;
    if (!looks_.empty()) builder_.keepCornersIn(corners);
    auto loaded = std::move(builder_).finish();
    if (!loaded) return loaded;
    for (const Look& look : looks_) {
      loaded->mesh.attributes.push_back(
          cornerAttribute(rowsOf(look), corners.points, corners, loaded->mesh));
    }
    return loaded;
  }

 private:
  /// Numbers of vertices that become an attribute.
  struct Look {
    std::string name;
    model::ScalarType type;
    std::vector<std::size_t> properties;  // of an element's row
    std::vector<double> numbers = {};     // of all points
  };

  static std::vector<std::size_t> propertiesOf(const PlyElement& element,
                                               std::initializer_list<std::string_view> names,
                                               auto isRight) {
    std::vector<std::size_t> found;
    for (const std::string_view name : names) {
      const auto at = std::ranges::find_if(element.properties, [&](const PlyProperty& property) {
        return property.name == name && !property.isList && isRight(property.type);
      });
      if (at == element.properties.end()) return {};
      found.push_back(static_cast<std::size_t>(at - element.properties.begin()));
    }
    return found;
  }

  void findLooks(const PlyElement& element) {
    const auto isByte = [](PlyType type) { return type == PlyType::UInt8; };
    const auto isFloat = [](PlyType type) {
      return type == PlyType::Float32 || type == PlyType::Float64;
    };
    auto colors = propertiesOf(element, {"red", "green", "blue", "alpha"}, isByte);
    if (colors.empty()) colors = propertiesOf(element, {"red", "green", "blue"}, isByte);
    if (!colors.empty()) looks_.push_back({"color", model::ScalarType::UInt8, colors});
    for (const auto& names : {std::array{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}}) {
      const auto places = propertiesOf(element, {names[0], names[1]}, isFloat);
      if (places.empty()) continue;
      looks_.push_back({"uv", model::ScalarType::Float32, places});
      break;
    }
  }

  static model::Attribute rowsOf(const Look& look) {
    model::Attribute rows{look.name,
                          model::Domain::Vertex,
                          look.type,
                          static_cast<std::uint32_t>(look.properties.size()),
                          {}};
    const std::size_t bytes = scalarSize(look.type);
    rows.values.resize(look.numbers.size() * bytes);
    for (std::size_t i = 0; i < look.numbers.size(); ++i) {
      std::byte* to = rows.values.data() + i * bytes;
      const auto byte = static_cast<std::uint8_t>(look.numbers[i]);
      const auto real = static_cast<float>(look.numbers[i]);
      if (look.type == model::ScalarType::UInt8) std::memcpy(to, &byte, 1);
      if (look.type == model::ScalarType::Float32) std::memcpy(to, &real, 4);
    }
    return rows;
  }

  Result<void> readElement(const PlyElement& element) {
    if (element.properties.empty()) return {};  // there is nothing in the file
    std::size_t rowBytes = 0;
    for (const PlyProperty& property : element.properties) {
      rowBytes += Rows::leastBytes(property.isList ? property.countType : property.type);
    }
    if (element.count > rows_.bytesLeft() / rowBytes) {
      return invalid(
          fmt::format("declares {} of element {}, more than the {} bytes after the header "
                      "can hold",
                      element.count, inQuotes(element.name), rows_.bytesLeft()),
          rows_.where());
    }
    if (element.name == "vertex") builder_.reserve(element.count, 0);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (!rows_.nextRow()) {
        return invalid(fmt::format("the file ends after {} of {} of element {}", row, element.count,
                                   inQuotes(element.name)),
                       rows_.where());
      }
      if (auto done = readRow(element); !done) return done;
    }
    return {};
  }

  Result<void> readRow(const PlyElement& element) {
    const auto place = rows_.place();
    const bool isVertex = element.name == "vertex";
    const bool isStrip = element.name == "tristrips";
    const bool isFace = element.name == "face" || isStrip;
    model::Point3 point = model::Point3::Zero();
    if (isVertex) row_.assign(element.properties.size(), 0);
    for (const PlyProperty& property : element.properties) {
      if (property.isList) {
        const bool isCorners = isFace && isCornerList(property);
        if (auto done = readList(property, isCorners, isStrip); !done) return done;
        if (!isCorners || isStrip) continue;
        if (auto done = builder_.addPolygon(corners_, place); !done) return done;
      } else {
        double value = 0;
        if (!rows_.next(property.type, value, "a number")) return rows_.error();
        const std::size_t axis = std::string_view("xyz").find(property.name);
        if (isVertex && property.name.size() == 1 && axis < 3) {
          point[static_cast<Eigen::Index>(axis)] = value;
        }
        if (isVertex && !looks_.empty())
          row_[static_cast<std::size_t>(&property - element.properties.data())] = value;
      }
    }
    if (auto done = rows_.endRow(); !done) return done;
    if (!isVertex) return {};
    for (Look& look : looks_) {
      for (const std::size_t at : look.properties) look.numbers.push_back(row_[at]);
    }
    return builder_.addPoint(point, place);
  }

  /// Reads the corners of a face into corners_, or adds the strips of a list of strips, in which -1
  /// ends a strip. The entries of other lists are skipped; they need not be whole numbers.
  Result<void> readList(const PlyProperty& property, bool isCorners, bool isStrip) {
    double count = 0;
    if (!rows_.next(property.countType, count, "the length of a list")) return rows_.error();
    const std::uint64_t most = rows_.bytesLeft() / Rows::leastBytes(property.type);
    if (!isIndex(count) || count > static_cast<double>(most)) {
      return invalid(fmt::format("a list of length {}, expected 0 to {}", count, most),
                     rows_.where());
    }
    corners_.clear();
    auto place = rows_.place();
    for (auto left = static_cast<std::uint64_t>(count); left > 0; --left) {
      double corner = 0;
      if (!rows_.next(property.type, corner, "an entry of a list")) return rows_.error();
      if (!isCorners) continue;
      if (isStrip && corner == -1) {
        if (auto done = builder_.addStrip(corners_, place); !done) return done;
        corners_.clear();
        place = rows_.place();
        continue;
      }
      if (!isIndex(corner)) {
        return invalid(
            fmt::format("a face refers to vertex {}, expected a whole number from 0 on", corner),
            rows_.where());
      }
      corners_.push_back(static_cast<std::uint64_t>(corner));
    }
    if (!isStrip) return {};
    return builder_.addStrip(corners_, place);
  }

  static bool isCornerList(const PlyProperty& property) {
    return property.name == "vertex_indices" || property.name == "vertex_index";
  }

  static bool isIndex(double value) {
    constexpr double kMost = 4294967295.0;  // of a 32-bit number, the largest that PLY has
    return value >= 0 && value <= kMost && value == std::floor(value);
  }

  Rows rows_;
  MeshBuilder builder_;
  std::vector<std::uint64_t> corners_;
  std::vector<Look> looks_;
  std::vector<double> row_;  // of a vertex
};

}  // namespace

Result<LoadedMesh> readPly(const InputFile& file, Keep keep) {
  TextScanner scanner(file);
  auto header = readPlyHeader(scanner);
  if (!header) return header.error();
  if (header->encoding == PlyEncoding::Text) {
    return PlyReader(file, TextRows(file, scanner), [&](auto line) { return file.atLine(line); })
        .read(*header, keep);
  }
  const auto order =
      header->encoding == PlyEncoding::BigEndian ? std::endian::big : std::endian::little;
  return PlyReader(file, BinaryRows(file, scanner, order), [&](auto at) { return file.atByte(at); })
      .read(*header, keep);
}

}  // namespace t4d::formats
