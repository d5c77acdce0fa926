#include "formats/mesh4d/g4mf_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <string>

#include <Eigen/LU>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/mesh4d/g4mf_file.h"
#include "formats/mesh4d/mesh4d_builder.h"
#include "formats/mesh4d/polyhedra.h"
#include "model/amount_text.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

using nlohmann::json;

constexpr int kDeepestNodes = 200;

/// Nodes may place a mesh many times, so that a small file could ask for any amount of memory. A
/// vertex or a tetrahedron takes at least 4 bytes where it is not repeated.
constexpr std::uint64_t kMostElementsPerByte = 16;

/// Rotors of files have few digits.
constexpr double kRotorRounding = 1e-3;

struct Placement {
  Eigen::Matrix4d basis = Eigen::Matrix4d::Identity();
  Eigen::Vector4d position = Eigen::Vector4d::Zero();
};

/// Whether the product of two blades of the geometric algebra, sets of axes as bits, is negative:
/// sorting their axes takes an odd number of exchanges.
bool isNegativeProduct(unsigned a, unsigned b) {
  int exchanges = 0;
  for (a >>= 1U; a != 0; a >>= 1U) exchanges += std::popcount(a & b);
  return exchanges % 2 != 0;
}

using Multivector = std::array<double, 16>;  // by the axes of the blade

Multivector product(const Multivector& a, const Multivector& b) {
  Multivector result{};
  for (unsigned i = 0; i < a.size(); ++i) {
    for (unsigned j = 0; j < b.size(); ++j) {
      result[i ^ j] += isNegativeProduct(i, j) ? -a[i] * b[j] : a[i] * b[j];
    }
  }
  return result;
}

/// The rotation of the rotor R, given as [1, xy, xz, yz, xw, yw, zw, xyzw]: it takes v to R~ v R,
/// so that cos(a/2) + sin(a/2) xy turns x towards y by the angle a, as in the format's own program.
/// Nothing if it is not a rotation.
std::optional<Eigen::Matrix4d> rotationOf(std::span<const double> rotor) {
  constexpr std::array<unsigned, 8> kBlades = {0,      0b0011, 0b0101, 0b0110,
                                               0b1001, 0b1010, 0b1100, 0b1111};
  double squares = 0;
  for (const double number : rotor) squares += number * number;
  const double length = std::sqrt(squares);
  if (!(std::abs(length - 1) <= kRotorRounding)) return std::nullopt;
  Multivector forward{};
  Multivector reverse{};
  for (std::size_t i = 0; i < rotor.size(); ++i) {
    forward[kBlades[i]] = rotor[i] / length;
    // Bivectors change their sign, the scalar and the blade of all axes do not.
    reverse[kBlades[i]] = (i == 0 || i == 7 ? 1 : -1) * rotor[i] / length;
  }
  Eigen::Matrix4d matrix;
  for (int axis = 0; axis < 4; ++axis) {
    Multivector vector{};
    vector[1U << static_cast<unsigned>(axis)] = 1;
    const Multivector turned = product(product(reverse, vector), forward);
    for (int row = 0; row < 4; ++row) matrix(row, axis) = turned[1U << static_cast<unsigned>(row)];
  }
  if (!(matrix * matrix.transpose()).isIdentity(kRotorRounding)) return std::nullopt;
  return matrix;
}

class G4mfReader {
 public:
  explicit G4mfReader(G4mfFile& file) : file_(file) {}

  Result<LoadedMesh4d> read() {
    const json& document = file_.document();
    const std::size_t nodes = document.contains("nodes") ? document["nodes"].size() : 0;
    if (nodes > 0) {
      seen_.resize(nodes);
      if (auto done = readNode(0, {}, 0); !done) return done.error();
    } else if (document.contains("meshes")) {
      for (std::size_t i = 0; i < document["meshes"].size(); ++i) {
        if (auto done = readMesh(i, {}, textOf(document["meshes"][i], "name"), amountsOf(i));
            !done) {
          return done.error();
        }
      }
    }
    if (loaded_.bodies.empty()) return file_.wrong("holds no tetrahedra");
    std::vector<std::string> skipped;
    for (const char* member : {"materials", "textures", "lights", "skins"}) {
      if (document.contains(member) && !document[member].empty()) skipped.emplace_back(member);
    }
    for (const std::string& member : skipped_) skipped.push_back(member);
    if (!skipped.empty()) {
      loaded_.losses.push_back(fmt::format("{}: {} are not read", file_.wrong("").where.text(),
                                           fmt::join(skipped, ", ")));
    }
    if (blended_) {
      loaded_.notices.emplace_back("vertices are moved by blend shapes, as much as the file says");
    }
    if (hidden_ > 0) {
      loaded_.notices.push_back(fmt::format("{} that the file hides, and what is below, not read",
                                            model::counted(hidden_, "node")));
    }
    loaded_.otherFiles = file_.otherFiles();
    return std::move(loaded_);
  }

 private:
  static std::string textOf(const json& object, const char* member) {
    const auto found = object.find(member);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
  }

  /// An array of so many numbers; empty if the member is missing.
  Result<std::vector<double>> numbers(const json& object, const char* member,
                                      std::initializer_list<std::size_t> sizes) const {
    const auto found = object.find(member);
    std::vector<double> values;
    if (found == object.end()) return values;
    const bool good =
        found->is_array() && std::ranges::find(sizes, found->size()) != sizes.end() &&
        std::ranges::all_of(*found, [](const json& value) { return value.is_number(); });
    if (!good) {
      return file_.wrong(
          fmt::format("the '{}' of a node is not {} numbers", member, fmt::join(sizes, " or ")));
    }
    for (const json& value : *found) values.push_back(value.get<double>());
    return values;
  }

  Result<Placement> placementOf(const json& node, const Placement& above) const {
    const auto position = numbers(node, "position", {4});
    if (!position) return position.error();
    const auto basis = numbers(node, "basis", {16});
    if (!basis) return basis.error();
    const auto scale = numbers(node, "scale", {1, 4});
    if (!scale) return scale.error();
    const auto rotor = numbers(node, "rotor", {7, 8});
    if (!rotor) return rotor.error();
    Placement own;
    if (!basis->empty()) {
      own.basis = Eigen::Map<const Eigen::Matrix4d>(basis->data());  // column by column
    } else {
      if (!rotor->empty()) {
        const auto rotation = rotationOf(*rotor);
        if (!rotation) {
          return file_.wrong(fmt::format(
              "the 'rotor' [{}] of a node is not a rotation: its length is not 1, or 'xyzw' does "
              "not match its planes",
              fmt::join(*rotor, ", ")));
        }
        own.basis = *rotation;
      }
      if (!scale->empty()) {
        for (std::size_t i = 0; i < 4; ++i) {
          own.basis.col(static_cast<Eigen::Index>(i)) *= (*scale)[scale->size() == 1 ? 0 : i];
        }
      }
    }
    if (!position->empty()) own.position = Eigen::Map<const Eigen::Vector4d>(position->data());
    return Placement{above.basis * own.basis, above.basis * own.position + above.position};
  }

  Result<void> readNode(std::uint64_t number, const Placement& above, int depth) {
    if (depth > kDeepestNodes || seen_[number]) {
      return file_.wrong(
          fmt::format("node {} is below itself, has two parents or is too deep", number));
    }
    seen_[number] = true;
    const json& node = file_.document()["nodes"][number];
    const auto placement = placementOf(node, above);
    if (!placement) return placement.error();
    for (const auto& [member, what] :
         {std::pair{"camera", "cameras"}, std::pair{"light", "lights"},
          std::pair{"modelInstance", "models of other files"}, std::pair{"physics", "physics"}}) {
      if (node.contains(member)) skipped_.insert(what);
    }
    if (node.value("visible", json(true)) == json(false)) {
      ++hidden_;
      return {};
    }
    const auto instance = node.find("meshInstance");
    const bool isInstance = instance != node.end() && instance->is_object();
    const auto mesh = file_.index(isInstance ? *instance : node, "mesh", "meshes");
    if (!mesh) return mesh.error();
    if (*mesh) {
      const json& amounts = isInstance && instance->contains("blendAmounts")
                                ? (*instance)["blendAmounts"]
                                : amountsOf(**mesh);
      // Our own files have names there that the format forbids.
      const auto extras = node.find("extras");
      const bool hasOther =
          extras != node.end() && extras->is_object() && extras->contains("t4d_name");
      const std::string name = hasOther ? textOf(*extras, "t4d_name") : textOf(node, "name");
      if (auto done = readMesh(**mesh, *placement, name, amounts); !done) {
        return done;
      }
    }
    const auto children = node.find("children");
    if (children == node.end()) return {};
    if (!children->is_array()) return file_.wrong("the 'children' of a node are not an array");
    for (const json& child : *children) {
      const auto index = file_.index({{"child", child}}, "child", "nodes");
      if (!index) return index.error();
      if (!*index) continue;
      if (auto done = readNode(**index, *placement, depth + 1); !done) return done;
    }
    return {};
  }

  /// How much of each blend shape a mesh has where its instance does not say so; null for nothing.
  const json& amountsOf(std::uint64_t mesh) const {
    static const json nothing;
    const json& found = file_.document()["meshes"][mesh];
    const auto blend = found.find("blend");
    const bool has = blend != found.end() && blend->is_object() && blend->contains("amounts");
    return has ? (*blend)["amounts"] : nothing;
  }

  /// Moves vertices by the blend shapes of a mesh.
  Result<void> blend(std::uint64_t number, const json& amounts, std::vector<double>& vertices) {
    if (amounts.is_null()) return {};
    const json& mesh = file_.document()["meshes"][number];
    const auto found = mesh.find("blend");
    const bool hasShapes = found != mesh.end() && found->is_object() && found->contains("shapes") &&
                           (*found)["shapes"].is_array();
    const std::size_t count = hasShapes ? (*found)["shapes"].size() : 0;
    const bool good = amounts.is_array() && amounts.size() == count &&
                      std::ranges::all_of(amounts, [](const json& one) { return one.is_number(); });
    if (!good) {
      return file_.wrong(fmt::format("the amounts of the blend shapes of mesh {} are not {}",
                                     number, model::counted(count, "number")));
    }
    for (std::size_t shape = 0; shape < count; ++shape) {
      const auto amount = amounts[shape].get<double>();
      const json& offsets = (*found)["shapes"][shape];
      if (amount == 0 || !offsets.is_object() || !offsets.contains("position")) continue;
      const std::string which = fmt::format("blend shape {} of mesh {}", shape, number);
      if (auto done = displace(offsets["position"], amount, which, vertices); !done) return done;
      blended_ = true;
    }
    return {};
  }

  /// Adds so much of the offsets of some vertices.
  Result<void> displace(const json& position, double amount, const std::string& which,
                        std::vector<double>& vertices) {
    const auto indices = file_.index(position, "indices", "accessors");
    if (!indices) return indices.error();
    const auto offsets = file_.index(position, "offsets", "accessors");
    if (!offsets) return offsets.error();
    if (!*indices || !*offsets) return file_.wrong(which + " lacks indices or offsets");
    const auto targets = file_.accessor(**indices, 1);
    if (!targets) return targets.error();
    const auto moves = file_.accessor(**offsets);
    if (!moves) return moves.error();
    if (moves->size() != 4 * targets->size()) {
      return file_.wrong(fmt::format("{} has {} indices and {} offsets", which, targets->size(),
                                     moves->size() / 4));
    }
    if (auto good = countElements(targets->size()); !good) return good;
    for (std::size_t i = 0; i < targets->size(); ++i) {
      const double target = (*targets)[i];
      if (!(target >= 0 && target < static_cast<double>(vertices.size() / 4)) ||
          target != std::floor(target)) {
        return file_.wrong(
            fmt::format("{} moves vertex {} of {}", which, target, vertices.size() / 4));
      }
      for (std::size_t k = 0; k < 4; ++k) {
        vertices[4 * static_cast<std::size_t>(target) + k] += amount * (*moves)[4 * i + k];
      }
    }
    return {};
  }

  Result<void> countElements(std::size_t more) {
    elements_ += more;
    if (elements_ <= kMostElementsPerByte * file_.bytes()) return {};
    return fail(ErrorCode::Unsupported,
                fmt::format("its nodes repeat meshes too often: {} vertices and tetrahedra from {} "
                            "bytes",
                            elements_, file_.bytes()),
                file_.wrong("").where);
  }

  Result<void> addVertices(std::uint64_t mesh, std::uint64_t accessor, const Placement& placement,
                           const json& amounts, Mesh4dBuilder& builder) {
    auto numbers = file_.accessor(accessor);
    if (!numbers) return numbers.error();
    if (auto done = blend(mesh, amounts, *numbers); !done) return done;
    const bool moved = !placement.basis.isIdentity(0) || !placement.position.isZero(0);
    builder.reserve(builder.vertexCount() + numbers->size() / 4, 0);
    for (std::size_t i = 0; i < numbers->size(); i += 4) {
      model::Point4 vertex = Eigen::Map<const model::Point4>(numbers->data() + i);
      if (moved) vertex = placement.basis * vertex + placement.position;
      if (auto added = builder.addVertex(vertex, i / 4); !added) return added;
    }
    return {};
  }

  /// Accessors of geometry: a count and so many numbers below `limit`, again and again.
  Result<std::vector<std::vector<std::uint32_t>>> listsOf(const json& accessor, std::size_t limit,
                                                          std::uint64_t mesh) {
    const auto wrong = [&](const char* what) {
      return file_.wrong(fmt::format("the geometry of mesh {} has {}", mesh, what));
    };
    const auto index = file_.index({{"geometry", accessor}}, "geometry", "accessors");
    if (!index) return index.error();
    if (!*index) return wrong("no accessor");
    const auto numbers = file_.accessor(**index, 1);
    if (!numbers) return numbers.error();
    std::vector<std::vector<std::uint32_t>> lists;
    for (std::size_t at = 0; at < numbers->size();) {
      const double count = (*numbers)[at++];
      if (!(count >= 3 && count <= static_cast<double>(numbers->size() - at)) ||
          count != std::floor(count)) {
        return wrong("an element of fewer than 3 others, or more than follow");
      }
      auto& list = lists.emplace_back();
      for (const auto end = at + static_cast<std::size_t>(count); at < end; ++at) {
        const double number = (*numbers)[at];
        if (!(number >= 0 && number < static_cast<double>(limit)) || number != std::floor(number)) {
          return wrong("a number that is out of range");
        }
        list.push_back(static_cast<std::uint32_t>(number));
      }
    }
    return lists;
  }

  /// The corners of a face, which lists its edges in order around it; none if they do not meet.
  static std::vector<std::uint32_t> cornersOf(const std::vector<std::uint32_t>& face,
                                              const std::vector<double>& edges) {
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const double* const one = &edges[2 * std::size_t{face[i]}];
      const double* const next = &edges[2 * std::size_t{face[(i + 1) % face.size()]}];
      const double* const common = std::find_first_of(one, one + 2, next, next + 2);
      if (common == one + 2) return {};
      corners.push_back(static_cast<std::uint32_t>(*common));
    }
    return corners;
  }

  /// Adds the tetrahedra of a surface that has polyhedra, faces and edges in their place. Returns
  /// whether it has them.
  Result<bool> addGeometry(const json& surface, std::uint64_t mesh, Mesh4dBuilder& builder) {
    const auto geometry = surface.find("geometry");
    const auto edgesIndex = file_.index(surface, "edges", "accessors");
    if (!edgesIndex) return edgesIndex.error();
    const bool has = geometry != surface.end() && geometry->is_array() && geometry->size() >= 2;
    if (!has || !*edgesIndex) return false;
    const auto edges = file_.accessor(**edgesIndex, 2);
    if (!edges) return edges.error();
    const auto faces = listsOf((*geometry)[0], edges->size() / 2, mesh);
    if (!faces) return faces.error();
    const auto cells = listsOf((*geometry)[1], faces->size(), mesh);
    if (!cells) return cells.error();
    Polyhedra polyhedra;
    for (const auto& face : *faces) {
      const auto corners = cornersOf(face, *edges);
      const bool good = !corners.empty() && std::ranges::all_of(corners, [&](std::uint32_t corner) {
        return corner < builder.vertexCount();
      });
      if (!good) return file_.wrong(fmt::format("a face of mesh {} has no corners", mesh));
      polyhedra.addFace(corners);
    }
    for (const auto& cell : *cells) polyhedra.addCell(cell);
    const auto notice = polyhedra.addTo(builder);
    if (!notice) return notice.error();
    if (!notice->empty()) loaded_.notices.push_back(fmt::format("mesh {}: {}", mesh, *notice));
    return true;
  }

  Result<void> readMesh(std::uint64_t number, const Placement& placement, const std::string& name,
                        const json& amounts) {
    const json& mesh = file_.document()["meshes"][number];
    if (mesh.contains("skin")) skipped_.insert("skins");
    const Place file = file_.wrong("").where;
    Mesh4dBuilder builder(placeIn(file, fmt::format("mesh {}", number)), [&](auto i) {
      return placeIn(file, fmt::format("mesh {}, element {}", number, i));
    });
    const auto shared = file_.index(mesh, "vertices", "accessors");
    if (!shared) return shared.error();
    if (*shared) {
      if (auto added = addVertices(number, **shared, placement, amounts, builder); !added)
        return added;
    }
    const auto surfaces = mesh.find("surfaces");
    if (surfaces == mesh.end() || !surfaces->is_array()) {
      return file_.wrong(fmt::format("mesh {} has no 'surfaces'", number));
    }
    // A mirror turns the tetrahedra.
    const double largest = placement.basis.cwiseAbs().maxCoeff();
    const bool mirrored = (placement.basis / largest).determinant() < 0;
    bool any = false;
    for (const json& surface : *surfaces) {
      if (!surface.is_object()) return file_.wrong("a surface is not an object");
      auto cells = file_.index(surface, "simplexes", "accessors");
      if (cells && !*cells) cells = file_.index(surface, "cells", "accessors");
      if (!cells) return cells.error();
      if (!*cells) {
        const auto added = addGeometry(surface, number, builder);
        if (!added) return added.error();
        any = any || *added;
        continue;
      }
      any = true;
      std::size_t first = 0;
      if (!*shared) {
        const auto own = file_.index(surface, "vertices", "accessors");
        if (!own) return own.error();
        if (!*own) return file_.wrong(fmt::format("mesh {} has no vertices", number));
        first = builder.vertexCount();
        if (auto added = addVertices(number, **own, placement, amounts, builder); !added)
          return added;
      }
      const std::size_t end = builder.vertexCount();
      const auto corners = file_.accessor(**cells);
      if (!corners) return corners.error();
      for (std::size_t i = 0; i < corners->size(); i += 4) {
        std::array<std::uint64_t, 4> cell{};
        for (std::size_t k = 0; k < 4; ++k) {
          const double corner = (*corners)[i + k];
          if (!(corner >= 0 && corner < static_cast<double>(end - first)) ||
              corner != std::floor(corner)) {
            return file_.wrong(fmt::format("tetrahedron {} of mesh {} refers to vertex {} of {}",
                                           i / 4, number, corner, end - first));
          }
          cell[k] = first + static_cast<std::uint64_t>(corner);
        }
        if (mirrored) std::swap(cell[2], cell[3]);
        if (auto added = builder.addCell(cell, 0, i / 4); !added) return added;
      }
    }
    if (!any) return {};
    auto body = std::move(builder).finish();
    if (!body) return body.error();
    if (auto good = countElements(body->bodies[0].vertices.size() + body->bodies[0].cells.size());
        !good) {
      return good;
    }
    body->bodies[0].name = name;
    loaded_.bodies.push_back(std::move(body->bodies[0]));
    for (std::string& notice : body->notices) loaded_.notices.push_back(std::move(notice));
    return {};
  }

  G4mfFile& file_;
  LoadedMesh4d loaded_;
  std::vector<bool> seen_;         // nodes
  std::set<std::string> skipped_;  // what nodes and meshes have besides
  bool blended_ = false;
  std::uint64_t hidden_ = 0;
  std::uint64_t elements_ = 0;  // vertices and tetrahedra so far
};

}  // namespace

bool isG4mfBinary(std::string_view begin) { return begin.starts_with("G4MF"); }

bool isG4mfText(std::string_view begin) {
  const auto first = begin.find_first_not_of(" \t\r\n");
  return first != begin.npos && begin[first] == '{' && begin.find("\"dimension\"") != begin.npos;
}

Result<LoadedMesh4d> readG4mf(const InputFile& file) {
  auto g4mf = G4mfFile::open(file);
  if (!g4mf) return g4mf.error();
  auto loaded = G4mfReader(*g4mf).read();
  if (loaded) loaded->dialect = isG4mfBinary(file.bytes) ? "binary, draft" : "text, draft";
  return loaded;
}

}  // namespace t4d::formats
