#include "t4d/formats/gltf_reader.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "t4d/formats/gltf_losses.h"
#include "t4d/formats/gltf_model.h"
#include "t4d/formats/mesh_builder.h"

namespace t4d::formats {
namespace {

// A few bytes of JSON can instantiate a mesh any number of times. More numbers than this, or than
// the file has bytes, count as an attack.
constexpr std::size_t kMostInstanced = std::size_t{1} << 26;

/// A mesh and the transform that places it.
struct Instance {
  int mesh;
  Eigen::Affine3d world;
};

class Reader {
 public:
  Reader(const InputFile& file, const tinygltf::Model& model)
      : file_(file),
        model_(model),
        builder_(file.path.string(), [this](auto place) { return places_[place]; }) {}

  Result<LoadedMesh> read() {
    const auto instances = model_.nodes.empty() ? allMeshes() : placedMeshes();
    if (!instances) return pass(instances.error());
    if (auto good = checkCost(*instances); !good) return pass(good.error());
    for (const auto& [mesh, world] : *instances) {
      if (auto done = readMesh(mesh, world); !done) return pass(done.error());
    }
    auto loaded = std::move(builder_).finish();
    if (!loaded) return loaded;
    if (hidden_ > 0) {
      loaded->notices.push_back(
          fmt::format("left out {}, whose scale is zero", counted(hidden_, "hidden node")));
    }
    if (sheared_ > 0) {
      loaded->notices.emplace_back(
          "matrices of nodes shear the mesh, which glTF does not allow; they are applied as they "
          "are");
    }
    loaded->losses = gltfLosses(model_, used_);
    return loaded;
  }

 private:
  std::string element(const char* kind, int index) const {
    return fmt::format("{}: {}[{}]", file_.path.string(), kind, index);
  }

  Result<std::vector<Instance>> allMeshes() {
    std::vector<Instance> all;
    all.reserve(model_.meshes.size());
    for (int i = 0; i < static_cast<int>(model_.meshes.size()); ++i) {
      all.push_back({i, Eigen::Affine3d::Identity()});
      used_.meshes.insert(i);
    }
    return all;
  }

  /// Fails, before anything is read, when the instances have more than `kMostInstanced` numbers.
  Result<void> checkCost(const std::vector<Instance>& instances) const {
    std::size_t bufferBytes = 0;
    for (const auto& buffer : model_.buffers) bufferBytes += buffer.data.size();
    const auto numbersOf = [&](int accessor) -> std::size_t {
      const auto* found = elementAt(model_.accessors, accessor);
      // A count beyond the buffers is another error, found later.
      return found == nullptr ? 0 : std::min(found->count, bufferBytes);
    };
    std::size_t budget = std::max(kMostInstanced, file_.bytes.size() + bufferBytes);
    for (const auto& [index, world] : instances) {
      const auto* mesh = elementAt(model_.meshes, index);
      if (mesh == nullptr) continue;
      for (const auto& primitive : mesh->primitives) {
        const auto position = primitive.attributes.find("POSITION");
        const std::size_t cost =
            numbersOf(primitive.indices) +
            (position == primitive.attributes.end() ? 0 : 3 * numbersOf(position->second));
        if (cost > budget) {
          return fail(ErrorCode::Unsupported,
                      "its nodes instantiate more geometry than the file holds; merge them into "
                      "one mesh",
                      element("meshes", index));
        }
        budget -= cost;
      }
    }
    return {};
  }

  /// The root nodes: those of the default scene, or all without a parent.
  Result<std::vector<int>> roots() const {
    if (!model_.scenes.empty()) {
      const int index = std::max(model_.defaultScene, 0);
      const auto* scene = elementAt(model_.scenes, index);
      if (scene == nullptr) {
        return invalid(fmt::format("does not exist; there are {}", model_.scenes.size()),
                       element("scenes", index));
      }
      return scene->nodes;
    }
    std::vector<bool> isChild(model_.nodes.size(), false);
    for (const auto& node : model_.nodes) {
      for (const int child : node.children) {
        if (elementAt(model_.nodes, child) != nullptr)
          isChild[static_cast<std::size_t>(child)] = true;
      }
    }
    std::vector<int> found;
    for (std::size_t i = 0; i < isChild.size(); ++i) {
      if (!isChild[i]) found.push_back(static_cast<int>(i));
    }
    return found;
  }

  Result<std::vector<Instance>> placedMeshes() {
    const auto first = roots();
    if (!first) return pass(first.error());
    struct Visit {
      int node;
      int parent;             // -1 for none
      Eigen::Affine3d world;  // of the parent
      bool hidden;
    };
    // An explicit stack: a chain of nodes may be too long for recursion.
    std::vector<Visit> open;
    const auto push = [&](const std::vector<int>& nodes, const Visit& parent) {
      for (auto i = nodes.rbegin(); i != nodes.rend(); ++i) {
        open.push_back({*i, parent.node, parent.world, parent.hidden});
      }
    };
    push(*first, {-1, -1, Eigen::Affine3d::Identity(), false});
    std::vector<bool> visited(model_.nodes.size(), false);
    std::vector<int> parents(model_.nodes.size(), -1);
    std::vector<Instance> placed;
    while (!open.empty()) {
      const auto [index, parent, parentWorld, parentHidden] = open.back();
      open.pop_back();
      const auto* node = elementAt(model_.nodes, index);
      if (node == nullptr) {
        return invalid(fmt::format("does not exist; there are {}", model_.nodes.size()),
                       element("nodes", index));
      }
      if (visited[static_cast<std::size_t>(index)]) {
        return invalid("has two parents or is its own ancestor", element("nodes", index));
      }
      visited[static_cast<std::size_t>(index)] = true;
      parents[static_cast<std::size_t>(index)] = parent;
      const auto local = localTransform(*node, index);
      if (!local) return pass(local.error());
      const Eigen::Affine3d world = parentWorld * *local;
      const bool hidden = world.linear().isZero(0);
      hidden_ += hidden && !parentHidden;
      if (node->mesh >= 0) {
        if (!hidden) placed.push_back({node->mesh, world});
        used_.meshes.insert(node->mesh);
        // An insertion that finds the node has found its ancestors, too.
        for (int i = index; i >= 0 && used_.nodes.insert(i).second;) {
          i = parents[static_cast<std::size_t>(i)];
        }
      }
      push(node->children, {index, parent, world, hidden});
    }
    return placed;
  }

  Result<Eigen::Affine3d> localTransform(const tinygltf::Node& node, int index) {
    const auto hasSize = [](const std::vector<double>& numbers, std::size_t size) {
      return numbers.empty() || numbers.size() == size;
    };
    if (!hasSize(node.matrix, 16) || !hasSize(node.translation, 3) || !hasSize(node.rotation, 4) ||
        !hasSize(node.scale, 3)) {
      return invalid("a transform with the wrong number of values", element("nodes", index));
    }
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    if (!node.matrix.empty()) {
      const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
      if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
        return invalid("a matrix whose last row is not 0 0 0 1", element("nodes", index));
      }
      transform.matrix() = matrix;
      // glTF allows products of a scale, a rotation and a translation only.
      const Eigen::Matrix3d products = transform.linear().transpose() * transform.linear();
      const Eigen::Vector3d squares = products.diagonal();
      constexpr double kSquare = 1e-3;  // far above the rounding of float32
      for (const auto& [i, j] : {std::pair{0, 1}, {1, 2}, {2, 0}}) {
        sheared_ += std::abs(products(i, j)) > kSquare * std::sqrt(squares[i] * squares[j]);
      }
      return transform;
    }
    if (!node.translation.empty()) {
      transform.translation() = Eigen::Map<const Eigen::Vector3d>(node.translation.data());
    }
    if (!node.rotation.empty()) {
      const auto& r = node.rotation;
      const Eigen::Quaterniond rotation(r[3], r[0], r[1], r[2]);
      constexpr double kUnit = 1e-2;  // far above the rounding of float32
      if (!(std::abs(rotation.norm() - 1) <= kUnit)) {
        return invalid(
            fmt::format("a rotation by a quaternion of length {}, expected 1", rotation.norm()),
            element("nodes", index));
      }
      transform.linear() = rotation.normalized().toRotationMatrix();
    }
    if (!node.scale.empty()) {
      transform.linear() *= Eigen::Map<const Eigen::Vector3d>(node.scale.data()).asDiagonal();
    }
    return transform;
  }

  Result<void> readMesh(int index, const Eigen::Affine3d& world) {
    const auto* mesh = elementAt(model_.meshes, index);
    if (mesh == nullptr) {
      return invalid(fmt::format("does not exist; there are {}", model_.meshes.size()),
                     element("meshes", index));
    }
    for (std::size_t i = 0; i < mesh->primitives.size(); ++i) {
      places_.push_back(fmt::format("{}.primitives[{}]", element("meshes", index), i));
      if (auto done = readPrimitive(mesh->primitives[i], world); !done) return done;
    }
    return {};
  }

  Result<void> readPrimitive(const tinygltf::Primitive& primitive, const Eigen::Affine3d& world) {
    const int mode = primitive.mode;
    if (mode >= TINYGLTF_MODE_POINTS && mode <= TINYGLTF_MODE_LINE_STRIP) return {};
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
        mode != TINYGLTF_MODE_TRIANGLE_FAN) {
      return invalid(fmt::format("mode {}, expected 0 to 6", mode), places_.back());
    }
    if (primitive.extensions.count("KHR_draco_mesh_compression") > 0) {
      return fail(ErrorCode::Unsupported,
                  "is compressed by KHR_draco_mesh_compression, which is not supported",
                  places_.back());
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) return {};  // allowed, and draws nothing

    const std::uint64_t first = builder_.pointCount();
    const auto count = addPoints(position->second, world);
    if (!count) return pass(count.error());
    const auto corners = cornersOf(primitive, *count);
    if (!corners) return pass(corners.error());
    return addTriangles(mode, *corners, first, world.linear().determinant() < 0);
  }

  Result<std::size_t> addPoints(int accessor, const Eigen::Affine3d& world) {
    const auto numbers = readGltfAccessor(file_, model_, accessor, 3);
    if (!numbers) return pass(numbers.error());
    for (std::size_t i = 0; i < numbers->size(); i += 3) {
      const Eigen::Map<const Eigen::Vector3d> point(numbers->data() + i);
      if (auto added = builder_.addPoint(world * point, places_.size() - 1); !added) {
        return pass(added.error());
      }
    }
    return numbers->size() / 3;
  }

  Result<std::vector<std::uint64_t>> cornersOf(const tinygltf::Primitive& primitive,
                                               std::size_t pointCount) {
    std::vector<std::uint64_t> corners;
    if (primitive.indices < 0) {
      for (std::size_t i = 0; i < pointCount; ++i) corners.push_back(i);
      return corners;
    }
    const auto numbers = readGltfAccessor(file_, model_, primitive.indices, 1);
    if (!numbers) return pass(numbers.error());
    corners.reserve(numbers->size());
    for (const double number : *numbers) {
      const auto corner = static_cast<std::uint64_t>(std::max(number, 0.0));
      if (static_cast<double>(corner) != number || corner >= pointCount) {
        return invalid(fmt::format("index {} is {}, but {} has {} positions", corners.size(),
                                   number, places_.back(), pointCount),
                       element("accessors", primitive.indices));
      }
      corners.push_back(corner);
    }
    return corners;
  }

  /// The order of corners in strips and fans is that of the glTF 2.0 specification, 3.7.2.1. A
  /// mirroring transform reverses the triangles.
  Result<void> addTriangles(int mode, const std::vector<std::uint64_t>& corners,
                            std::uint64_t first, bool mirrored) {
    const bool separate = mode == TINYGLTF_MODE_TRIANGLES;
    if (separate && corners.size() % 3 != 0) {
      return invalid(
          fmt::format("{} corners of triangles, expected a multiple of 3", corners.size()),
          places_.back());
    }
    for (std::size_t i = 0; i + 2 < corners.size(); i += separate ? 3 : 1) {
      std::array<std::size_t, 3> at{i, i + 1, i + 2};
      if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) at = {i, i + 1 + i % 2, i + 2 - i % 2};
      if (mode == TINYGLTF_MODE_TRIANGLE_FAN) at = {i + 1, i + 2, 0};
      if (mirrored) std::swap(at[1], at[2]);
      const std::array<std::uint64_t, 3> triangle{first + corners[at[0]], first + corners[at[1]],
                                                  first + corners[at[2]]};
      if (auto added = builder_.addPolygon(triangle, places_.size() - 1); !added) return added;
    }
    return {};
  }

  const InputFile& file_;
  const tinygltf::Model& model_;
  std::vector<std::string> places_;
  MeshBuilder builder_;
  std::size_t hidden_ = 0;
  std::size_t sheared_ = 0;
  GltfUse used_;
};

}  // namespace

Result<LoadedMesh> readGltf(const InputFile& file) {
  auto loaded = loadGltfModel(file);
  if (!loaded) return pass(loaded.error());
  auto mesh = Reader(file, loaded->model).read();
  if (mesh) mesh->otherFiles = std::move(loaded->bufferFiles);
  return mesh;
}

}  // namespace t4d::formats
