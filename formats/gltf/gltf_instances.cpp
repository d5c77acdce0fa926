#include "formats/gltf/gltf_instances.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "formats/gltf/gltf_geometry.h"

namespace t4d::formats {
namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

const tinygltf::Value* instancingOf(const tinygltf::Node& node) {
  const auto found = node.extensions.find(kInstancing);
  return found == node.extensions.end() ? nullptr : &found->second;
}

class InstanceReader {
 public:
  InstanceReader(const InputFile& file, const tinygltf::Model& model, int node)
      : file_(file),
        model_(model),
        where_(gltfElement(file, "nodes", node, fmt::format(".{}", kInstancing))) {}

  Result<std::size_t> count(const tinygltf::Value& extension) {
    if (!extension.IsObject() || !extension.Get("attributes").IsObject() ||
        extension.Get("attributes").Size() == 0) {
      return invalid("has no attributes", where_);
    }
    const auto& attributes = extension.Get("attributes").Get<tinygltf::Value::Object>();
    std::size_t count = 0;
    std::string counted;
    for (const auto& [name, value] : attributes) {
      const int index = value.IsInt() ? value.Get<int>() : -1;
      const auto* accessor = elementAt(model_.accessors, index);
      if (accessor == nullptr) {
        return invalid(fmt::format("its attribute {} is not an accessor; there are {}", name,
                                   model_.accessors.size()),
                       where_);
      }
      if (!counted.empty() && accessor->count != count) {
        return invalid(fmt::format("has {} of {} and {} of {}; expected as many of each attribute",
                                   count, counted, accessor->count, name),
                       where_);
      }
      count = accessor->count;
      counted = name;
      (name == "TRANSLATION" ? translation_
       : name == "ROTATION"  ? rotation_
       : name == "SCALE"     ? scale_
                             : other_) = index;
    }
    return count;
  }

  Result<std::vector<Eigen::Affine3d>> read(const tinygltf::Value& extension) {
    const auto found = count(extension);
    if (!found) return found.error();
    // If no other attribute says how many there are, this one has to exist.
    if (other_ >= 0) {
      const auto type = model_.accessors[static_cast<std::size_t>(other_)].type;
      const int width = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type));
      const auto read = readGltfAccessor(file_, model_, other_, std::max(width, 1));
      if (!read) return read.error();
    }
    std::vector<Eigen::Affine3d> transforms(*found, Eigen::Affine3d::Identity());
    if (translation_ >= 0) {
      const auto numbers = numbersOf(translation_, 3);
      if (!numbers) return numbers.error();
      for (std::size_t i = 0; i < transforms.size(); ++i) {
        transforms[i].translation() = Eigen::Map<const Eigen::Vector3d>(&(*numbers)[3 * i]);
      }
    }
    if (rotation_ >= 0) {
      if (auto done = turn(transforms); !done) return done.error();
    }
    if (scale_ >= 0) {
      const auto numbers = numbersOf(scale_, 3);
      if (!numbers) return numbers.error();
      for (std::size_t i = 0; i < transforms.size(); ++i) {
        transforms[i].linear() *=
            Eigen::Map<const Eigen::Vector3d>(&(*numbers)[3 * i]).asDiagonal();
      }
    }
    return transforms;
  }

 private:
  Result<void> turn(std::vector<Eigen::Affine3d>& transforms) const {
    const auto numbers = numbersOf(rotation_, 4);
    if (!numbers) return numbers.error();
    for (std::size_t i = 0; i < transforms.size(); ++i) {
      const double* xyzw = &(*numbers)[4 * i];
      const Eigen::Quaterniond rotation(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
      constexpr double kUnit = 1e-2;  // above the rounding of 8-bit numbers, 0.008
      if (!(std::abs(rotation.norm() - 1) <= kUnit)) {
        return invalid(
            fmt::format("element {} is a quaternion of length {}, expected 1", i, rotation.norm()),
            gltfElement(file_, "accessors", rotation_));
      }
      transforms[i].linear() = rotation.normalized().toRotationMatrix();
    }
    return {};
  }

  /// Floats; of quaternions also normalised integers with a sign.
  Result<std::vector<double>> numbersOf(int index, int components) const {
    const auto& accessor = model_.accessors[static_cast<std::size_t>(index)];
    const int type = accessor.componentType;
    const bool small =
        type == TINYGLTF_COMPONENT_TYPE_BYTE || type == TINYGLTF_COMPONENT_TYPE_SHORT;
    if (type != TINYGLTF_COMPONENT_TYPE_FLOAT &&
        !(components == 4 && small && accessor.normalized)) {
      return invalid(
          fmt::format("component type {}{}; {} has {}", type,
                      accessor.normalized ? ", normalized" : "", kInstancing,
                      components == 4 ? "5126 (float), or 5120 or 5122 (normalized) in rotations"
                                      : "5126 (float) in translations and scales"),
          gltfElement(file_, "accessors", index));
    }
    auto numbers = readGltfAccessor(file_, model_, index, components);
    if (!numbers) return numbers;
    const auto wrong =
        std::ranges::find_if_not(*numbers, [](double x) { return std::isfinite(x); });
    if (wrong != numbers->end()) {
      return invalid(fmt::format("element {} has a number that is not finite",
                                 (wrong - numbers->begin()) / components),
                     gltfElement(file_, "accessors", index));
    }
    return numbers;
  }

  const InputFile& file_;
  const tinygltf::Model& model_;
  Place where_;
  int translation_ = -1;
  int rotation_ = -1;
  int scale_ = -1;
  int other_ = -1;  // one of those without a meaning for places
};

}  // namespace

Result<std::size_t> countGltfInstances(const InputFile& file, const tinygltf::Model& model,
                                       int node) {
  const auto* extension = instancingOf(model.nodes[static_cast<std::size_t>(node)]);
  if (extension == nullptr) return 1;
  return InstanceReader(file, model, node).count(*extension);
}

Result<std::vector<Eigen::Affine3d>> readGltfInstances(const InputFile& file,
                                                       const tinygltf::Model& model, int node) {
  const auto* extension = instancingOf(model.nodes[static_cast<std::size_t>(node)]);
  if (extension == nullptr) return std::vector{Eigen::Affine3d::Identity()};
  return InstanceReader(file, model, node).read(*extension);
}

std::vector<std::string> gltfInstanceAttributes(const tinygltf::Node& node) {
  const auto* extension = instancingOf(node);
  if (extension == nullptr || !extension->Get("attributes").IsObject()) return {};
  return extension->Get("attributes").Keys();
}

}  // namespace t4d::formats
