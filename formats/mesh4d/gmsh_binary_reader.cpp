#include "formats/mesh4d/gmsh_binary_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "formats/mesh4d/gmsh_mesh.h"
#include "formats/text/byte_scanner.h"
#include "formats/text/text_scanner.h"
#include "model/number.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

constexpr std::int32_t kGmshTetrahedron = 4;  // the type of elements with four nodes

/// Nodes of an element of each type, from 1; types that Gmsh does not document have 0.
constexpr std::array<std::uint8_t, 32> kNodesOfType = {0,  2,  3,  4,  4, 8, 6,  5,  3,  6, 9,
                                                       10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10,
                                                       12, 15, 15, 21, 4, 5, 6,  20, 35, 56};

std::uint64_t nodesOfType(std::int32_t type) {
  if (type == 92) return 64;
  if (type == 93) return 125;
  return type > 0 && type < std::ssize(kNodesOfType) ? kNodesOfType[static_cast<unsigned>(type)]
                                                     : 0;
}

/// A line of a text, and where the next begins; nothing if the text ends before it.
std::optional<std::string_view> lineAt(std::string_view text, std::size_t at) {
  const std::size_t end = text.find('\n', at);
  if (end == text.npos) return std::nullopt;
  std::string_view line = text.substr(at, end - at);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

class GmshBinaryReader {
 public:
  explicit GmshBinaryReader(const InputFile& file)
      : file_(file),
        bytes_(file, 0, std::endian::little),
        mesh_(file.path, [&file](auto offset) { return file.atByte(offset); }) {}

  Result<LoadedMesh4d> read() {
    while (skipBlanks()) {
      const auto section = line("a section, as $Nodes");
      if (!section) return section.error();
      if (!section->starts_with('$')) {
        return bytes_.invalidHere(
            fmt::format("found {} before here, expected a section, as $Nodes", inQuotes(*section)));
      }
      if (auto done = readSection(*section); !done) return done.error();
    }
    return std::move(mesh_).finish(order_ == std::endian::big ? "MSH 4.1, binary, big-endian"
                                                              : "MSH 4.1, binary");
  }

 private:
  Result<void> readSection(std::string_view section) {
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
    } else {
      skipping_ = true;
    }
    if (!done) return done;
    // Only sections that are not read have anything before their end.
    const std::string end = "$End" + std::string(section.substr(1));
    const std::size_t found = file_.bytes.find(end, bytes_.at());
    if (found == std::string::npos) {
      return invalid(fmt::format("the file ends before {}", end), file_.atByte(file_.bytes.size()));
    }
    if (!std::exchange(skipping_, false) &&
        file_.bytes.find_first_not_of("\r\n", bytes_.at()) != found) {
      return bytes_.invalidHere(fmt::format("found other bytes, expected {}", end));
    }
    bytes_.goTo(found + end.size());
    return {};
  }

  /// Whether anything but blanks follows.
  bool skipBlanks() {
    const std::size_t next = file_.bytes.find_first_not_of(" \t\r\n", bytes_.at());
    bytes_.goTo(std::min(next, file_.bytes.size()));
    return next != std::string::npos;
  }

  Result<std::string_view> line(std::string_view what) {
    const auto found = lineAt(file_.bytes, bytes_.at());
    if (!found) {
      return invalid(fmt::format("the file ends, expected {}", what),
                     file_.atByte(file_.bytes.size()));
    }
    bytes_.goTo(file_.bytes.find('\n', bytes_.at()) + 1);
    return *found;
  }

  /// A line with a whole number.
  Result<std::int64_t> lineNumber(std::string_view what) {
    const std::size_t begin = bytes_.at();
    const auto text = line(what);
    if (!text) return text.error();
    if (const auto value = model::numberIn<std::int64_t>(*text)) return *value;
    return invalid(fmt::format("found {}, expected {}", inQuotes(*text), what),
                   file_.atByte(begin));
  }

  Result<void> readFormat() {
    const std::size_t begin = bytes_.at();
    const auto format = line("the version");
    if (!format) return format.error();
    if (*format != "4.1 1 8") {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("is of the format {}, expected '4.1 1 8': MSH 4.1, binary, sizes of 8 "
                      "bytes; Gmsh writes it with `-format msh41 -bin`",
                      inQuotes(*format)),
          file_.atByte(begin));
    }
    const auto one = bytes_.number<std::int32_t>("a 1 of 4 bytes");
    if (!one) return one.error();
    if (*one != 1 && *one != 1 << 24) {
      return invalid(fmt::format("found {}, expected a 1 in either byte order", *one),
                     file_.atByte(bytes_.at() - 4));
    }
    if (*one != 1) order_ = std::endian::big;
    bytes_.setOrder(order_);
    return {};
  }

  /// Reads names, which are text even in binary files.
  Result<void> readPhysicalNames() {
    const auto count = lineNumber("the number of physical names");
    if (!count) return count.error();
    for (std::int64_t i = 0; i < *count; ++i) {
      const std::size_t begin = bytes_.at();
      const auto name = line("a physical name");
      if (!name) return name.error();
      const InputFile only{file_.path, std::string(*name)};
      TextScanner text(only);
      std::int64_t dimension = 0;
      std::int64_t group = 0;
      if (!text.nextLine() || !text.integer(dimension, "a dimension") ||
          !text.integer(group, "a tag")) {
        return invalid(
            fmt::format("found {}, expected a dimension, a tag and a name", inQuotes(*name)),
            file_.atByte(begin));
      }
      std::string_view quoted = text.rest();
      if (quoted.size() >= 2 && quoted.starts_with('"') && quoted.ends_with('"')) {
        quoted = quoted.substr(1, quoted.size() - 2);
      }
      if (dimension == 3) mesh_.nameGroup(group, std::string(quoted));
    }
    return {};
  }

  Result<void> readEntities() {
    std::array<std::uint64_t, 4> counts{};
    for (std::uint64_t& count : counts) {
      const auto number = bytes_.number<std::uint64_t>("a number of entities");
      if (!number) return number.error();
      count = *number;
    }
    for (int dimension = 0; dimension < 4; ++dimension) {
      const std::uint64_t bounds = dimension == 0 ? 3 * 8 : 6 * 8;
      if (auto good = bytes_.checkCount(counts[dimension], 4 + bounds + 8, "entities"); !good) {
        return good;
      }
      for (std::uint64_t i = 0; i < counts[dimension]; ++i) {
        if (auto good = bytes_.checkLeft(1, 4 + bounds, "an entity"); !good) return good;
        const auto tag = bytes_.next<std::int32_t>();
        bytes_.skip(bounds);
        const auto groups = bytes_.number<std::uint64_t>("the number of physical tags");
        if (!groups) return groups.error();
        if (auto good = bytes_.checkCount(*groups, 4, "physical tags"); !good) return good;
        for (std::uint64_t k = 0; k < *groups; ++k) {
          const auto group = bytes_.next<std::int32_t>();
          if (k == 0 && dimension == 3) mesh_.setGroup(tag, group);
        }
        if (dimension == 0) continue;
        const auto sides = bytes_.number<std::uint64_t>("the number of bounding entities");
        if (!sides) return sides.error();
        if (auto good = bytes_.checkCount(*sides, 4, "bounding entities"); !good) return good;
        bytes_.skip(4 * *sides);
      }
    }
    return {};
  }

  /// What a section of nodes or elements begins with: the number of blocks.
  Result<std::uint64_t> readHead() {
    if (auto good = bytes_.checkLeft(4, 8, "the numbers of blocks and elements"); !good) {
      return good.error();
    }
    const auto blocks = bytes_.next<std::uint64_t>();
    bytes_.skip(std::uint64_t{3} * 8);
    if (auto good = bytes_.checkCount(blocks, 3 * 4 + 8, "blocks"); !good) {
      return good.error();
    }
    return blocks;
  }

  struct BlockHead {
    std::int32_t dimension;
    std::int32_t entity;
    std::int32_t kind;  // of nodes: whether they have parameters; of elements: the type
    std::uint64_t count;
  };
  Result<BlockHead> readBlockHead() {
    if (auto good = bytes_.checkLeft(1, 3 * 4 + 8, "a block"); !good) return good.error();
    BlockHead head{};
    for (std::int32_t* number : {&head.dimension, &head.entity, &head.kind}) {
      *number = bytes_.next<std::int32_t>();
    }
    if (head.dimension < 0 || head.dimension > 3) {
      return invalid(fmt::format("a block has the dimension {}, expected 0 to 3", head.dimension),
                     file_.atByte(bytes_.at() - 12));
    }
    head.count = bytes_.next<std::uint64_t>();
    return head;
  }

  Result<std::int64_t> readTag() {
    const auto tag = bytes_.next<std::uint64_t>();
    if (tag <= std::numeric_limits<std::int64_t>::max()) return static_cast<std::int64_t>(tag);
    return invalid(fmt::format("found the tag {}, expected one below 2^63", tag),
                   file_.atByte(bytes_.at() - 8));
  }

  Result<std::size_t> readNode(std::int64_t tag, std::size_t place) {
    if (const auto found = mesh_.nodeOf(tag)) return *found;
    return invalid(fmt::format("refers to node {}, which does not exist", tag),
                   file_.atByte(place));
  }

  Result<void> readNodes() {
    const auto blocks = readHead();
    if (!blocks) return blocks.error();
    for (std::uint64_t block = 0; block < *blocks; ++block) {
      const auto head = readBlockHead();
      if (!head) return head.error();
      const std::uint64_t parameters =
          head->kind != 0 ? static_cast<std::uint64_t>(head->dimension) : 0;
      const std::uint64_t each = 8 * (3 + parameters);
      if (auto good = bytes_.checkCount(head->count, 8 + each, "nodes"); !good) return good;
      for (std::uint64_t i = 0; i < head->count; ++i) {
        const auto tag = readTag();
        if (!tag) return tag.error();
        if (!mesh_.addTag(*tag)) {
          return invalid(fmt::format("a second node has the tag {}", *tag),
                         file_.atByte(bytes_.at() - 8));
        }
      }
      for (std::uint64_t i = 0; i < head->count; ++i) {
        const std::size_t place = bytes_.at();
        model::Point3 point;
        for (double& coordinate : point) coordinate = bytes_.next<double>();
        bytes_.skip(8 * parameters);
        mesh_.addPoint(point, place);
      }
    }
    return {};
  }

  Result<void> readElements() {
    const auto blocks = readHead();
    if (!blocks) return blocks.error();
    for (std::uint64_t block = 0; block < *blocks; ++block) {
      const std::size_t begin = bytes_.at();
      const auto head = readBlockHead();
      if (!head) return head.error();
      const std::uint64_t nodes = nodesOfType(head->kind);
      if (nodes == 0 ||
          (head->dimension == 3 && head->kind != kGmshTetrahedron && head->count > 0)) {
        return fail(ErrorCode::Unsupported,
                    fmt::format("has {} elements of type {}, expected tetrahedra of four nodes (4)",
                                head->count, head->kind),
                    file_.atByte(begin));
      }
      if (auto good = bytes_.checkCount(head->count, 8 * (1 + nodes), "elements"); !good)
        return good;
      if (head->dimension != 3) {
        bytes_.skip(head->count * 8 * (1 + nodes));
        continue;
      }
      for (std::uint64_t i = 0; i < head->count; ++i) {
        const std::size_t place = bytes_.at();
        bytes_.skip(8);  // the tag
        std::array<std::uint64_t, 4> corners{};
        for (std::uint64_t& corner : corners) {
          const auto tag = readTag();
          if (!tag) return tag.error();
          const auto node = readNode(*tag, bytes_.at() - 8);
          if (!node) return node.error();
          corner = *node;
        }
        mesh_.addTetrahedron(corners, head->entity, place);
      }
    }
    return {};
  }

  /// Its tags are text.
  Result<void> readNodeData() {
    const auto strings = lineNumber("the number of string tags");
    if (!strings) return strings.error();
    std::string name;
    for (std::int64_t i = 0; i < *strings; ++i) {
      const auto text = line("a string tag");
      if (!text) return text.error();
      if (i == 0) name = std::string(*text);
    }
    skipping_ = !mesh_.isTime(name);
    if (skipping_) return {};
    const auto reals = lineNumber("the number of real tags");
    if (!reals) return reals.error();
    for (std::int64_t i = 0; i < *reals; ++i) {
      if (auto found = line("a real tag"); !found) return found.error();
    }
    const auto integers = lineNumber("the number of integer tags");
    if (!integers) return integers.error();
    std::array<std::int64_t, 3> about{};  // step, components, nodes
    for (std::int64_t i = 0; i < *integers; ++i) {
      const auto value = lineNumber("an integer tag");
      if (!value) return value.error();
      if (i < 3) about[static_cast<std::size_t>(i)] = *value;
    }
    if (about[1] != 1) {
      return bytes_.invalidHere(fmt::format("the time has {} components, expected 1", about[1]));
    }
    if (!mesh_.beginTimes()) return bytes_.invalidHere("has the time a second time");
    if (about[2] < 0) {
      return bytes_.invalidHere(fmt::format("the time has {} nodes, expected 0 or more", about[2]));
    }
    const auto count = static_cast<std::uint64_t>(about[2]);
    if (auto good = bytes_.checkCount(count, 4 + 8, "times"); !good) return good;
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto tag = bytes_.next<std::int32_t>();
      const auto node = readNode(tag, bytes_.at() - 4);
      if (!node) return node.error();
      mesh_.setTime(*node, bytes_.next<double>());
    }
    return {};
  }

  const InputFile& file_;
  ByteScanner bytes_;
  std::endian order_ = std::endian::little;
  GmshMesh mesh_;
  bool skipping_ = false;  // the rest of the section
};

}  // namespace

bool isGmshBinary(std::string_view begin) {
  if (!begin.starts_with("$MeshFormat")) return false;
  const std::size_t next = begin.find('\n');
  if (next == begin.npos) return false;
  const auto format = lineAt(begin, next + 1);
  if (!format) return false;
  const std::size_t blank = format->find(' ');
  return blank != format->npos && format->substr(blank).starts_with(" 1");
}

Result<LoadedMesh4d> readGmshBinary(const InputFile& file) { return GmshBinaryReader(file).read(); }

}  // namespace t4d::formats
