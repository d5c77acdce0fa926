#include "formats/mesh4d/gmsh_reader.h"

#include <array>

#include <fmt/format.h>

#include "formats/mesh4d/gmsh_binary_reader.h"
#include "formats/mesh4d/gmsh_mesh.h"
#include "formats/text/text_scanner.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

constexpr std::int64_t kTetrahedron4 = 4;  // the type of elements with four nodes

class GmshReader {
 public:
  explicit GmshReader(const InputFile& file)
      : text_(file), mesh_(file.path, [&file](auto line) { return file.atLine(line); }) {}

  Result<LoadedMesh4d> read() {
    while (text_.nextLine()) {
      const std::string_view section = text_.word();
      if (!section.starts_with('$')) return text_.unexpectedWord(section, "a section, as '$Nodes'");
      Result<void> done;
      if (section == "$MeshFormat") {
        done = readFormat();
      } else if (section == "$PhysicalNames") {
        done = readPhysicalNames();
      } else if (section == "$Entities") {
        done = readEntities();
      } else if (section == "$Nodes") {
        done = readNodes();
      } else if (section == "$Elements") {
        done = readElements();
      } else if (section == "$NodeData") {
        done = readNodeData();
      }
      if (done) done = skipTo("$End" + std::string(section.substr(1)));
      if (!done) return done.error();
    }
    return std::move(mesh_).finish("MSH 4.1, text");
  }

 private:
  Result<void> skipTo(const std::string& end) {
    while (text_.nextLine()) {
      if (text_.word() == end) return {};
    }
    return text_.invalidHere(fmt::format("the file ends before {}", end));
  }

  Result<void> nextLine(const char* what) {
    if (text_.nextLine()) return {};
    return text_.invalidHere(fmt::format("the file ends, expected {}", what));
  }

  template <std::size_t N>
  Result<std::array<std::int64_t, N>> numbers(const char* what) {
    if (auto found = nextLine(what); !found) return found.error();
    std::array<std::int64_t, N> values{};
    for (std::int64_t& value : values) {
      if (!text_.integer(value, what)) return text_.error();
    }
    return values;
  }

  /// A count of lines of at least `shortest` bytes each.
  Result<void> checkCount(std::int64_t count, std::size_t shortest, const char* what) {
    if (count >= 0 && static_cast<std::uint64_t>(count) <= text_.bytesLeft() / shortest + 1) {
      return {};
    }
    return text_.invalidHere(
        fmt::format("declares {} {}, which the {} bytes that follow cannot hold", count, what,
                    text_.bytesLeft()));
  }

  Result<void> readFormat() {
    if (auto found = nextLine("the version"); !found) return found;
    const std::string_view version = text_.word();
    if (version != "4.1") {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("is MSH version {}, expected 4.1; Gmsh writes it with `-format msh41`",
                      inQuotes(version)),
          text_.where());
    }
    std::int64_t binary = 0;
    if (!text_.integer(binary, "0 for text")) return text_.error();
    if (binary != 0) return text_.unexpectedWord(fmt::format("{}", binary), "0 for text");
    return {};
  }

  Result<void> readPhysicalNames() {
    const auto count = numbers<1>("the number of physical names");
    if (!count) return count.error();
    if (auto good = checkCount((*count)[0], 6, "physical names"); !good) return good;
    for (std::int64_t i = 0; i < (*count)[0]; ++i) {
      const auto group = numbers<2>("a dimension and a tag");
      if (!group) return group.error();
      std::string_view name = text_.rest();
      if (name.size() >= 2 && name.starts_with('"') && name.ends_with('"')) {
        name = name.substr(1, name.size() - 2);
      }
      if ((*group)[0] == 3) mesh_.nameGroup((*group)[1], std::string(name));
    }
    return {};
  }

  /// Only volumes matter; they come after points, curves and surfaces.
  Result<void> readEntities() {
    const auto counts = numbers<4>("the numbers of points, curves, surfaces and volumes");
    if (!counts) return counts.error();
    for (int dimension = 0; dimension < 4; ++dimension) {
      const std::int64_t count = (*counts)[dimension];
      if (auto good = checkCount(count, 8, "entities"); !good) return good;
      for (std::int64_t i = 0; i < count; ++i) {
        if (auto found = nextLine("an entity"); !found) return found;
        if (dimension < 3) continue;
        std::int64_t tag = 0;
        std::int64_t groups = 0;
        if (!text_.integer(tag, "a tag")) return text_.error();
        for (int k = 0; k < 6; ++k) {
          double bound = 0;
          if (!text_.number(bound, "a bound")) return text_.error();
        }
        if (!text_.integer(groups, "the number of physical tags")) return text_.error();
        std::int64_t group = 0;
        if (groups > 0 && !text_.integer(group, "a physical tag")) return text_.error();
        if (groups > 0) mesh_.setGroup(tag, group);
      }
    }
    return {};
  }

  Result<void> readNodes() {
    const auto head = numbers<4>("the numbers of blocks and nodes");
    if (!head) return head.error();
    if (auto good = checkCount((*head)[0], 8, "blocks"); !good) return good;
    for (std::int64_t block = 0; block < (*head)[0]; ++block) {
      const auto about = numbers<4>("a block of nodes");
      if (!about) return about.error();
      const std::int64_t count = (*about)[3];
      if (auto good = checkCount(count, 8, "nodes"); !good) return good;
      for (std::int64_t i = 0; i < count; ++i) {
        const auto tag = numbers<1>("the tag of a node");
        if (!tag) return tag.error();
        if (!mesh_.addTag((*tag)[0])) {
          return text_.invalidHere(fmt::format("a second node has the tag {}", (*tag)[0]));
        }
      }
      for (std::int64_t i = 0; i < count; ++i) {
        if (auto found = nextLine("the coordinates of a node"); !found) return found;
        model::Point3 point;
        for (int axis = 0; axis < 3; ++axis) {
          if (!text_.number(point[axis], "a coordinate")) return text_.error();
        }
        mesh_.addPoint(point, text_.line());
      }
    }
    return {};
  }

  Result<std::size_t> nodeOf(std::int64_t tag) {
    if (const auto found = mesh_.nodeOf(tag)) return *found;
    return text_.invalidHere(fmt::format("refers to node {}, which does not exist", tag));
  }

  Result<void> readElements() {
    const auto head = numbers<4>("the numbers of blocks and elements");
    if (!head) return head.error();
    if (auto good = checkCount((*head)[0], 8, "blocks"); !good) return good;
    for (std::int64_t block = 0; block < (*head)[0]; ++block) {
      const auto about = numbers<4>("a block of elements");
      if (!about) return about.error();
      const auto& [dimension, entity, type, count] = *about;
      if (auto good = checkCount(count, 4, "elements"); !good) return good;
      if (dimension == 3 && type != kTetrahedron4 && count > 0) {
        return fail(ErrorCode::Unsupported,
                    fmt::format("has {} elements of type {}, expected tetrahedra of four nodes (4)",
                                count, type),
                    text_.where());
      }
      for (std::int64_t i = 0; i < count; ++i) {
        if (auto found = nextLine("an element"); !found) return found;
        if (dimension != 3) continue;
        std::int64_t tag = 0;
        if (!text_.integer(tag, "the tag of an element")) return text_.error();
        std::array<std::uint64_t, 4> corners{};
        for (std::uint64_t& corner : corners) {
          if (!text_.integer(tag, "the tag of a node")) return text_.error();
          const auto node = nodeOf(tag);
          if (!node) return node.error();
          corner = *node;
        }
        mesh_.addTetrahedron(corners, entity, text_.line());
      }
    }
    return {};
  }

  Result<void> readNodeData() {
    const auto strings = numbers<1>("the number of string tags");
    if (!strings) return strings.error();
    std::string name;
    for (std::int64_t i = 0; i < (*strings)[0]; ++i) {
      if (auto found = nextLine("a string tag"); !found) return found;
      if (i == 0) name = std::string(text_.rest());
    }
    if (!mesh_.isTime(name)) return {};
    const auto reals = numbers<1>("the number of real tags");
    if (!reals) return reals.error();
    for (std::int64_t i = 0; i < (*reals)[0]; ++i) {
      if (auto found = nextLine("a real tag"); !found) return found;
    }
    const auto integers = numbers<1>("the number of integer tags");
    if (!integers) return integers.error();
    std::array<std::int64_t, 3> about{};  // step, components, nodes
    for (std::int64_t i = 0; i < (*integers)[0]; ++i) {
      const auto value = numbers<1>("an integer tag");
      if (!value) return value.error();
      if (i < 3) about[static_cast<std::size_t>(i)] = (*value)[0];
    }
    if (about[1] != 1) {
      return text_.invalidHere(fmt::format("the time has {} components, expected 1", about[1]));
    }
    if (!mesh_.beginTimes()) return text_.invalidHere("has the time a second time");
    for (std::int64_t i = 0; i < about[2]; ++i) {
      const auto tag = numbers<1>("the tag of a node and its time");
      if (!tag) return tag.error();
      const auto node = nodeOf((*tag)[0]);
      if (!node) return node.error();
      double time = 0;
      if (!text_.number(time, "a time")) return text_.error();
      mesh_.setTime(*node, time);
    }
    return {};
  }

  TextScanner text_;
  GmshMesh mesh_;
};

}  // namespace

bool isGmsh(std::string_view begin) {
  return begin.starts_with("$MeshFormat") && !isGmshBinary(begin);
}

Result<LoadedMesh4d> readGmsh(const InputFile& file) {
  return isGmshBinary(file.bytes) ? readGmshBinary(file) : GmshReader(file).read();
}

}  // namespace t4d::formats
