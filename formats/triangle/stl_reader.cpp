#include "formats/triangle/stl_reader.h"

#include <array>
#include <string_view>

#include <fmt/format.h>

#include "formats/text/text_scanner.h"
#include "formats/triangle/mesh_builder.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kHeaderBytes = 84;    // 80 of anything, then the count
constexpr std::size_t kTriangleBytes = 50;  // normal, three corners, two bytes of anything

std::string lowerCase(std::string_view word) {
  std::string lower;
  for (const char c : word) lower += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

bool looksLikeText(const std::string& bytes) {
  constexpr std::size_t kLooked = 512;
  const std::string_view begin = std::string_view(bytes).substr(0, kLooked);
  const std::size_t word = begin.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return word != begin.npos && lowerCase(begin.substr(word, 5)) == "solid" &&
         begin.find('\0') == begin.npos;
}

std::uint64_t binaryBytes(const InputFile& file) {
  const auto count = loadNumber<std::uint32_t>(file.bytes.data() + kHeaderBytes - 4);
  return kHeaderBytes + kTriangleBytes * std::uint64_t{count};
}

Result<LoadedMesh> readBinary(const InputFile& file) {
  MeshBuilder builder(file.path.string(), [&](auto at) { return file.atByte(at); });
  const std::size_t count = (file.bytes.size() - kHeaderBytes) / kTriangleBytes;
  builder.reserve(3 * count, count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t triangle = kHeaderBytes + i * kTriangleBytes;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::size_t at = triangle + 12 + 12 * corner;
      const char* from = file.bytes.data() + at;
      const model::Point3 point(loadNumber<float>(from), loadNumber<float>(from + 4),
                                loadNumber<float>(from + 8));
      if (auto added = builder.addPoint(point, at); !added) return added.error();
    }
    const std::array<std::uint64_t, 3> corners{3 * i, 3 * i + 1, 3 * i + 2};
    if (auto added = builder.addPolygon(corners, triangle); !added) return added.error();
  }
  return std::move(builder).finish();
}

/// solid NAME { facet normal X Y Z  outer loop  { vertex X Y Z }x3  endloop  endfacet } endsolid
class TextReader {
 public:
  explicit TextReader(const InputFile& file)
      : scanner_(file),
        builder_(file.path.string(), [&](auto line) { return file.atLine(line); }) {}

  Result<LoadedMesh> read() {
    auto word = lowerCase(scanner_.wordAcrossLines());
    do {
      if (word != "solid") return scanner_.unexpectedWord(word, "'solid'");
      scanner_.rest();  // the name
      while ((word = lowerCase(scanner_.wordAcrossLines())) == "facet") {
        if (auto done = readFacet(); !done) return done.error();
      }
      if (word != "endsolid") {
        return scanner_.unexpectedWord(word, "'facet' or 'endsolid'");
      }
      scanner_.rest();
      word = lowerCase(scanner_.wordAcrossLines());
    } while (!word.empty());
    return std::move(builder_).finish();
  }

 private:
  Result<void> expect(std::initializer_list<const char*> words) {
    for (const char* expected : words) {
      const auto found = scanner_.wordAcrossLines();
      if (lowerCase(found) != expected) {
        return scanner_.unexpectedWord(found, fmt::format("'{}'", expected));
      }
    }
    return {};
  }

  Result<void> readFacet() {
    const auto line = scanner_.line();
    if (auto done = expect({"normal"}); !done) return done;
    // Some writers give a flat triangle the normal "nan"; it is not used.
    for (int i = 0; i < 3; ++i) scanner_.wordAcrossLines();
    if (auto done = expect({"outer", "loop"}); !done) return done;
    const std::uint64_t first = builder_.pointCount();
    for (int corner = 0; corner < 3; ++corner) {
      if (auto done = expect({"vertex"}); !done) return done;
      model::Point3 point;
      for (double& coordinate : point) {
        if (!scanner_.parse(scanner_.wordAcrossLines(), coordinate, "a coordinate")) {
          return scanner_.error();
        }
      }
      if (auto added = builder_.addPoint(point, scanner_.line()); !added) return added;
    }
    if (auto done = expect({"endloop", "endfacet"}); !done) return done;
    return builder_.addPolygon(std::array{first, first + 1, first + 2}, line);
  }

  TextScanner scanner_;
  MeshBuilder builder_;
};

}  // namespace

Result<LoadedMesh> readStl(const InputFile& file, Keep /*keep*/) {
  const std::size_t size = file.bytes.size();
  const bool hasHeader = size >= kHeaderBytes;
  // Binary files may begin with "solid" too; a text file has no count that fits.
  if (hasHeader && binaryBytes(file) == size) return readBinary(file);
  if (looksLikeText(file.bytes)) return TextReader(file).read();
  if (!hasHeader) {
    return invalid(fmt::format("neither begins with 'solid' nor has the {} bytes of a binary "
                               "header: the file ends after {}",
                               kHeaderBytes, size),
                   file.path.string());
  }
  return invalid(
      fmt::format("the count is {} triangles, for which the file must have {} bytes; "
                  "it has {}",
                  (binaryBytes(file) - kHeaderBytes) / kTriangleBytes, binaryBytes(file), size),
      file.atByte(kHeaderBytes - 4));
}

}  // namespace t4d::formats
