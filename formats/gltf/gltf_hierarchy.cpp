#include "formats/gltf/gltf_hierarchy.h"

#include <algorithm>
#include <map>
#include <utility>

#include <Eigen/SVD>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/gltf/gltf_geometry.h"
#include "formats/gltf/gltf_target.h"

namespace t4d::formats {
namespace {

using Eigen::Affine3d;
using model::Point3;
using Side = GltfCurve::Side;
using Property = GltfTarget::Property;

class HierarchyReader {
 public:
  HierarchyReader(const InputFile& file, const tinygltf::Model& model,
                  std::span<const GltfNode> scene, std::span<const int> animations)
      : file_(file), model_(model), scene_(scene), animations_(animations) {}

  Result<GltfHierarchy> read() {
    readNodes();
    found_.weights.resize(model_.nodes.size(), nullptr);
    for (const int animation : animations_) {
      if (auto done = readChannels(animation); !done) return done.error();
    }
    if (!(found_.end > 0)) return nothingMoves();
    if (auto done = checkScales(); !done) return done.error();
    return std::move(found_);
  }

 private:
  void readNodes() {
    found_.nodes.resize(model_.nodes.size());
    for (const GltfNode& node : scene_) {
      const auto& from = model_.nodes[static_cast<std::size_t>(node.index)];
      GltfMovingNode made;
      made.parent = node.parent;
      made.local = node.local;
      made.translation = node.local.translation();
      made.visible = node.visible;
      if (!from.rotation.empty()) {
        made.rotation = Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(from.rotation.data()));
        made.rotation.normalize();
      }
      if (!from.scale.empty()) made.scale = Eigen::Map<const Point3>(from.scale.data());
      found_.nodes[static_cast<std::size_t>(node.index)] = made;
    }
  }

  std::optional<GltfMovingNode>* nodeAt(int index) {
    const bool exists = index >= 0 && static_cast<std::size_t>(index) < found_.nodes.size();
    auto* node = exists ? &found_.nodes[static_cast<std::size_t>(index)] : nullptr;
    return node != nullptr && node->has_value() ? node : nullptr;
  }

  Result<void> readChannels(int animation) {
    const auto& channels = model_.animations[static_cast<std::size_t>(animation)].channels;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      const Place where =
          gltfElement(file_, "animations", animation, fmt::format(".channels[{}]", i));
      const GltfTarget target = gltfTargetOf(model_, channels[i]);
      if (target.property == Property::Other) found_.others.push_back(target.name);
      for (const int node : target.nodes) {
        if (auto done = readChannel(target, node, animation, channels[i].sampler, where); !done) {
          return done;
        }
      }
    }
    return {};
  }

  Error nothingMoves() const {
    const std::string others = found_.others.empty() ? std::string()
                                                     : fmt::format("; what moves is not read: {}",
                                                                   fmt::join(found_.others, ", "));
    return invalid(
        fmt::format("has no key after time 0 that moves a node of the scene, so nothing moves{}",
                    others),
        animations_.size() > 1 ? Place(file_.path.string())
                               : gltfElement(file_, "animations", animations_.front()),
        Remedy::GiveMotion);
  }

  Result<void> readChannel(const GltfTarget& target, int index, int animation, int sampler,
                           const Place& where) {
    const auto* moved = elementAt(model_.nodes, index);
    if (moved == nullptr && index >= 0) {
      return invalid(fmt::format("moves node {}, which does not exist; there are {}", index,
                                 model_.nodes.size()),
                     where);
    }
    auto* node = nodeAt(index);
    // Nodes outside the scene move nothing.
    if (node == nullptr || target.property == Property::Other) return {};
    const GltfCurve*& slot = slotOf(**node, index, target.property);
    if (slot != nullptr) {
      return invalid(
          fmt::format("moves the {} of node {}, as another {} does", target.name, index,
                      animationOf_.at(slot) == animation ? "channel" : "animation that is read"),
          where);
    }
    const bool isWeights = target.property == Property::Weights;
    if (!moved->matrix.empty() && !isWeights && target.property != Property::Visible) {
      return invalid(fmt::format("moves node {}, which has a matrix", index), where);
    }
    const auto [kind, width] = valueOf(target.property, moved->mesh);
    if (width == 0) {
      return invalid(
          fmt::format("moves the weights of node {}, whose mesh has no morph targets", index),
          where);
    }
    auto curve = GltfCurve::read(file_, model_, animation, sampler, kind, width);
    if (!curve) return curve.error();
    found_.end = std::max(found_.end, curve->times().back());
    found_.keysBeforeZero += curve->times().size() - curve->timesFromZero().size();
    found_.curves.push_back(std::make_unique<GltfCurve>(std::move(*curve)));
    slot = found_.curves.back().get();
    animationOf_[slot] = animation;
    return {};
  }

  const GltfCurve*& slotOf(GltfMovingNode& node, int index, Property property) {
    switch (property) {
      case Property::Translation:
        return node.translations;
      case Property::Rotation:
        return node.rotations;
      case Property::Scale:
        return node.scales;
      case Property::Visible:
        return node.visibles;
      default:
        return found_.weights[static_cast<std::size_t>(index)];
    }
  }

  std::pair<GltfCurve::Kind, int> valueOf(Property property, int mesh) const {
    switch (property) {
      case Property::Rotation:
        return {GltfCurve::Kind::Rotation, 4};
      case Property::Weights:
        return {GltfCurve::Kind::Weights, gltfTargetCount(model_, mesh)};
      case Property::Visible:
        return {GltfCurve::Kind::Truth, 1};
      default:
        return {GltfCurve::Kind::Vector, 3};
    }
  }

  /// A solid that shrinks to nothing, or through it, is no solid there.
  Result<void> checkScales() const {
    for (std::size_t i = 0; i < found_.nodes.size(); ++i) {
      if (!found_.nodes[i] || found_.nodes[i]->scales == nullptr) continue;
      const GltfCurve& scales = *found_.nodes[i]->scales;
      for (std::size_t key = 1; key < scales.times().size(); ++key) {
        const double begin = std::max(0.0, scales.times()[key - 1]);
        const double end = scales.times()[key];
        if (end <= begin || !shrinksToZero(scales, begin, end, 0)) continue;
        return invalid(
            fmt::format("its scale shrinks to zero, or through it, from time {} to {}; a solid "
                        "keeps a size, or is hidden by STEP keys of zero",
                        begin, end),
            gltfElement(file_, "nodes", static_cast<int>(i)));
      }
    }
    return {};
  }

  static bool shrinksToZero(const GltfCurve& scales, double begin, double end, int depth) {
    const Eigen::MatrixXd hull = scales.hull(begin, end).value;
    const Eigen::VectorXd least = hull.rowwise().minCoeff();
    const Eigen::VectorXd most = hull.rowwise().maxCoeff();
    bool clear = true;
    for (int axis = 0; axis < 3; ++axis) {
      const bool constant = least[axis] == most[axis];
      clear = clear && (constant || least[axis] > 0 || most[axis] < 0);
    }
    if (clear) return false;
    constexpr int kMostHalvings = 12;
    const double middle = begin / 2 + end / 2;
    if (depth == kMostHalvings || !(begin < middle && middle < end)) return true;
    return shrinksToZero(scales, begin, middle, depth + 1) ||
           shrinksToZero(scales, middle, end, depth + 1);
  }

  const InputFile& file_;
  const tinygltf::Model& model_;
  std::span<const GltfNode> scene_;
  std::span<const int> animations_;
  GltfHierarchy found_;
  std::map<const GltfCurve*, int> animationOf_;
};

}  // namespace

Affine3d GltfMovingNode::at(double time, Side side) const {
  Affine3d transform = local;
  if (moves()) {
    transform.translation() =
        translations != nullptr ? Point3(translations->at(time, side)) : translation;
    const Eigen::Quaterniond turn =
        rotations != nullptr ? Eigen::Quaterniond(Eigen::Vector4d(rotations->at(time, side)))
                             : rotation;
    const Point3 factors = scales != nullptr ? Point3(scales->at(time, side)) : scale;
    transform.linear() = turn.toRotationMatrix() * factors.asDiagonal();
  }
  return transform;
}

CurveBound GltfMovingNode::bound(const CurveBound& point, double begin, double end) const {
  if (!moves()) {
    const double stretch = local.linear().jacobiSvd().singularValues()[0];
    return CurveBound{local.translation().norm(), 0, 0} + CurveBound{stretch, 0, 0} * point;
  }
  CurveBound shift{translation.norm(), 0, 0};
  if (translations != nullptr) {
    const auto hull = translations->hull(begin, end);
    shift = {hull.value.colwise().norm().maxCoeff(), hull.first.colwise().norm().maxCoeff(),
             hull.second.colwise().norm().maxCoeff()};
  }
  CurveBound stretch{scale.cwiseAbs().maxCoeff(), 0, 0};
  if (scales != nullptr) {
    const auto hull = scales->hull(begin, end);
    stretch = {hull.value.cwiseAbs().maxCoeff(), hull.first.cwiseAbs().maxCoeff(),
               hull.second.cwiseAbs().maxCoeff()};
  }
  const CurveBound turn =
      rotations != nullptr ? rotations->rotationBound(begin, end) : CurveBound{1, 0, 0};
  return shift + turn * (stretch * point);
}

Affine3d GltfHierarchy::world(int index, double time, Side side) const {
  Affine3d transform = node(index).at(time, side);
  for (int i = node(index).parent; i >= 0; i = node(i).parent) {
    transform = node(i).at(time, side) * transform;
  }
  return transform;
}

bool GltfHierarchy::isVisible(int index, double time, Side side) const {
  for (int i = index; i >= 0; i = node(i).parent) {
    const GltfCurve* curve = node(i).visibles;
    if (curve != nullptr ? curve->at(time, side)[0] == 0 : !node(i).visible) return false;
  }
  return true;
}

CurveBound GltfHierarchy::bound(int index, CurveBound point, double begin, double end) const {
  for (int i = index; i >= 0; i = node(i).parent) point = node(i).bound(point, begin, end);
  return point;
}

Result<GltfHierarchy> readGltfHierarchy(const InputFile& file, const tinygltf::Model& model,
                                        std::span<const GltfNode> scene,
                                        std::span<const int> animations) {
  return HierarchyReader(file, model, scene, animations).read();
}

}  // namespace t4d::formats
