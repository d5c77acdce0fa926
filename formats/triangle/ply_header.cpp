#include "formats/triangle/ply_header.h"

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>

namespace t4d::formats {
namespace {

struct TypeName {
  std::string_view name;
  std::string_view sizedName;
  std::size_t size;
};

// The types are in the order of PlyType.
constexpr std::array<TypeName, 8> kTypes{{{"char", "int8", 1},
                                          {"uchar", "uint8", 1},
                                          {"short", "int16", 2},
                                          {"ushort", "uint16", 2},
                                          {"int", "int32", 4},
                                          {"uint", "uint32", 4},
                                          {"float", "float32", 4},
                                          {"double", "float64", 8}}};

Result<PlyType> typeNamed(std::string_view word, const TextScanner& scanner) {
  for (std::size_t i = 0; i < kTypes.size(); ++i) {
    if (word == kTypes[i].name || word == kTypes[i].sizedName) return static_cast<PlyType>(i);
  }
  return scanner.unexpectedWord(word, "a type such as 'float' or 'uint8'");
}

Result<PlyEncoding> readFormat(TextScanner& scanner) {
  const auto word = scanner.word();
  if (word == "ascii") return PlyEncoding::Text;
  if (word == "binary_little_endian") return PlyEncoding::LittleEndian;
  if (word == "binary_big_endian") return PlyEncoding::BigEndian;
  return scanner.unexpectedWord(word, "'ascii', 'binary_little_endian' or 'binary_big_endian'");
}

Result<PlyElement> readElement(TextScanner& scanner) {
  PlyElement element{std::string(scanner.word()), 0, {}};
  std::int64_t count = 0;
  if (!scanner.integer(count, "the element's name and count")) return scanner.error();
  if (count < 0) return scanner.invalidHere(fmt::format("declares {} elements", count));
  element.count = static_cast<std::uint64_t>(count);
  return element;
}

Result<PlyProperty> readProperty(TextScanner& scanner) {
  PlyProperty property;
  auto word = scanner.word();
  if (word == "list") {
    property.isList = true;
    const auto countType = typeNamed(scanner.word(), scanner);
    if (!countType) return countType.error();
    property.countType = *countType;
    word = scanner.word();
  }
  const auto type = typeNamed(word, scanner);
  if (!type) return type.error();
  property.type = *type;
  property.name = scanner.word();
  if (property.name.empty()) return scanner.unexpectedWord({}, "the property's name");
  return property;
}

bool has(const PlyElement& element, std::initializer_list<std::string_view> names, bool list) {
  return std::any_of(element.properties.begin(), element.properties.end(), [&](const auto& p) {
    return p.isList == list && std::find(names.begin(), names.end(), p.name) != names.end();
  });
}

Result<void> checkElements(const PlyHeader& header, const TextScanner& scanner) {
  for (const std::string_view name : {"vertex", "face", "tristrips"}) {
    if (std::ranges::count(header.elements, name, &PlyElement::name) > 1) {
      return scanner.invalidHere(
          fmt::format("the header ends, expected at most one element '{}'", name));
    }
  }
  const auto named = [&](std::string_view name) -> const PlyElement* {
    const auto found = std::ranges::find(header.elements, name, &PlyElement::name);
    return found == header.elements.end() ? nullptr : &*found;
  };
  const PlyElement* vertex = named("vertex");
  if (vertex == nullptr || !has(*vertex, {"x"}, false) || !has(*vertex, {"y"}, false) ||
      !has(*vertex, {"z"}, false)) {
    return scanner.invalidHere(
        "the header ends, expected one element 'vertex' with properties 'x', 'y' and 'z'");
  }
  for (const PlyElement* element : {named("face"), named("tristrips")}) {
    if (element != nullptr && has(*element, {"vertex_indices", "vertex_index"}, true)) return {};
  }
  return scanner.invalidHere(
      "the header ends, expected an element 'face' or 'tristrips' with a list 'vertex_indices'");
}

}  // namespace

std::size_t plySize(PlyType type) { return kTypes[static_cast<std::size_t>(type)].size; }

Result<PlyHeader> readPlyHeader(TextScanner& scanner) {
  scanner.nextLine();
  if (const auto word = scanner.word(); word != "ply") {
    return scanner.unexpectedWord(word, "'ply'");
  }
  PlyHeader header;
  std::optional<PlyEncoding> encoding;
  while (scanner.nextLine()) {
    const auto keyword = scanner.word();
    if (keyword == "comment" || keyword == "obj_info") {
      scanner.rest();
    } else if (keyword == "format") {
      const auto format = readFormat(scanner);
      if (!format) return format.error();
      encoding = *format;
    } else if (keyword == "element") {
      auto element = readElement(scanner);
      if (!element) return element.error();
      header.elements.push_back(std::move(*element));
    } else if (keyword == "property" && !header.elements.empty()) {
      auto property = readProperty(scanner);
      if (!property) return property.error();
      header.elements.back().properties.push_back(std::move(*property));
    } else if (keyword == "end_header") {
      if (!encoding) return scanner.invalidHere("the header ends, expected a line 'format'");
      scanner.rest();
      header.encoding = *encoding;
      if (auto good = checkElements(header, scanner); !good) return good.error();
      return header;
    } else {
      return scanner.unexpectedWord(keyword, "a line of a PLY header");
    }
  }
  return scanner.invalidHere("the file ends, expected 'end_header'");
}

}  // namespace t4d::formats
