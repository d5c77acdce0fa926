#include "formats/mesh4d/fourdo_reader.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

#include "formats/mesh4d/mesh4d_builder.h"
#include "formats/text/text_scanner.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

std::string lower(std::string_view word) {
  std::string text(word);
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

class FourdoReader {
 public:
  explicit FourdoReader(const InputFile& file)
      : file_(file),
        text_(file, {.comment = '#'}),
        mesh_(file.path.string(), [&file](auto line) { return file.atLine(line); }) {}

  Result<LoadedMesh4d> read() {
    text_.nextLine();
    text_.word();
    std::int64_t version = 0;
    if (!text_.integer(version, "the version, 1 or 2")) return text_.error();
    if (version != 1 && version != 2) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("is 4DO version {}, expected 1 or 2", version), text_.where());
    }
    while (text_.nextLine()) {
      const std::string keyword = lower(text_.word());
      Result<void> done;
      if (keyword == "v") {
        done = readVertex();
      } else if (keyword == "t") {
        done = readTetrahedron();
      } else if (keyword == "tformat") {
        done = readFormat();
      } else if (keyword == "orient") {
        done = readOrient();
      } else if (keyword == "p") {
        ++polylines_;
      }
      // Others say nothing about the tetrahedra.
      if (!done) return done.error();
    }
    auto loaded = std::move(mesh_).finish();
    if (!loaded) return loaded;
    if (mirrored_) {
      for (Mesh4d& body : loaded->bodies) {
        for (model::Cell& cell : body.cells) std::swap(cell[2], cell[3]);
      }
    }
    loaded->dialect = fmt::format("version {}", version);
    if (polylines_ > 0) {
      loaded->losses.push_back(
          fmt::format("{}: {} polylines are not read", file_.path.string(), polylines_));
    }
    return loaded;
  }

 private:
  Result<void> readVertex() {
    model::Point4 inFile;
    for (double& coordinate : inFile) {
      if (!text_.number(coordinate, "a coordinate (a vertex has four)")) return text_.error();
    }
    model::Point4 vertex;
    for (int i = 0; i < 4; ++i) vertex[i] = inFile[axis_[i]] * sign_[i];
    return mesh_.addVertex(vertex, text_.line());
  }

  /// `tformat co v/vn`: data of the tetrahedron, then those of a corner.
  Result<void> readFormat() {
    before_ = 0;
    while (text_.hasWord()) {
      const std::string word = lower(text_.word());
      if (!text_.hasWord()) {
        position_ = 0;
        std::string_view rest = word;
        while (true) {
          const auto slash = rest.find('/');
          if (rest.substr(0, slash) == "v") return {};
          if (slash == rest.npos) break;
          rest.remove_prefix(slash + 1);
          ++position_;
        }
        return text_.unexpectedWord(word, "a format with 'v', as 'v/vn'");
      }
      ++before_;
    }
    return text_.unexpectedWord({}, "a format, as 'v' or 'co v/vn'");
  }

  Result<void> readTetrahedron() {
    for (std::size_t i = 0; i < before_; ++i) text_.word();
    std::array<std::uint64_t, 4> corners{};
    for (std::uint64_t& corner : corners) {
      std::string_view word = text_.word();
      for (std::size_t i = 0; i < position_ && !word.empty(); ++i) {
        const auto slash = word.find('/');
        word = slash == word.npos ? std::string_view() : word.substr(slash + 1);
      }
      std::int64_t number = 0;
      if (!text_.parse(word.substr(0, word.find('/')), number, "the number of a vertex")) {
        return text_.error();
      }
      if (number < 0 || static_cast<std::uint64_t>(number) >= mesh_.vertexCount()) {
        return text_.invalidHere(fmt::format(
            "a tetrahedron refers to vertex {}, but there are {} so far, numbered from 0", number,
            mesh_.vertexCount()));
      }
      corner = static_cast<std::uint64_t>(number);
    }
    return mesh_.addCell(corners, 0, text_.line());
  }

  Result<void> readOrient() {
    if (mesh_.vertexCount() > 0) return text_.invalidHere("'orient' comes after the first vertex");
    std::array<bool, 4> seen{};
    mirrored_ = false;
    for (int i = 0; i < 4; ++i) {
      const std::string_view whole = text_.word();
      std::string_view word = whole;
      sign_[i] = word.starts_with('-') ? -1 : 1;
      if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
      const auto which = std::string_view("xyzw").find(lower(word));
      if (word.size() != 1 || which > 3 || seen[which]) {
        return text_.unexpectedWord(whole, "each of X, Y, Z and W once, with or without a sign");
      }
      seen[which] = true;
      axis_[i] = static_cast<int>(which);
      if (sign_[i] < 0) mirrored_ = !mirrored_;
    }
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        if (axis_[i] > axis_[j]) mirrored_ = !mirrored_;
      }
    }
    return {};
  }

  const InputFile& file_;
  TextScanner text_;
  Mesh4dBuilder mesh_;
  std::size_t before_ = 0;    // words of a tetrahedron before its corners
  std::size_t position_ = 0;  // place of the vertex among the data of a corner
  std::array<int, 4> axis_ = {0, 1, 2, 3};
  std::array<double, 4> sign_ = {1, 1, 1, 1};
  bool mirrored_ = false;
  std::uint64_t polylines_ = 0;
};

}  // namespace

bool is4do(std::string_view begin) {
  const InputFile file{"", std::string(begin)};
  TextScanner text(file, {.comment = '#'});
  return text.nextLine() && lower(text.word()) == "4do";
}

Result<LoadedMesh4d> read4do(const InputFile& file) { return FourdoReader(file).read(); }

}  // namespace t4d::formats
