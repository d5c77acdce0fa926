#include "formats/gltf/gltf_shape.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <Eigen/SVD>
#include <fmt/format.h>

namespace t4d::formats {
namespace {

using Eigen::Affine3d;
using model::Point3;
using Side = GltfCurve::Side;

double reachOf(const std::vector<Point3>& points) {
  double length = 0;
  for (const Point3& point : points) length = std::max(length, point.norm());
  return length;
}

/// Fills in what bounds need.
void measure(GltfShape& shape) {
  shape.baseReach = reachOf(shape.base);
  for (const auto& target : shape.targets) shape.targetReach.push_back(reachOf(target));
  shape.jointReach.assign(shape.joints.size(), 0);
  for (std::size_t i = 0; i < shape.influences.size(); ++i) {
    double sum = 0;
    for (const auto& [joint, weight] : shape.influences[i]) {
      shape.jointReach[joint] = std::max(shape.jointReach[joint],
                                         (shape.joints[joint].inverseBind * shape.base[i]).norm());
      sum += std::abs(weight);
    }
    shape.heaviest = std::max(shape.heaviest, sum);
  }
}

std::vector<Point3> morphed(const GltfShape& shape, double time, Side side) {
  std::vector<Point3> points = shape.base;
  const Eigen::VectorXd weights =
      shape.weightCurve != nullptr ? shape.weightCurve->at(time, side) : shape.weights;
  for (std::size_t k = 0; k < shape.targets.size(); ++k) {
    const double weight = weights[static_cast<Eigen::Index>(k)];
    if (weight == 0) continue;
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += weight * shape.targets[k][i];
  }
  return points;
}

class ShapeReader {
 public:
  ShapeReader(const InputFile& file, const tinygltf::Model& model, const GltfHierarchy& hierarchy)
      : file_(file), model_(model), hierarchy_(hierarchy) {}

  Result<GltfShape> read(int index, std::span<const GltfGeometry::Part> parts,
                         const LoadedMesh& mesh) const {
    const auto& node = model_.nodes[static_cast<std::size_t>(index)];
    GltfShape shape;
    shape.node = index;
    shape.base = mesh.mesh.vertices;
    shape.weightCurve = hierarchy_.weights[static_cast<std::size_t>(index)];
    if (auto done = readTargets(node, parts, mesh.points, shape); !done) return done.error();
    if (node.skin >= 0) {
      if (auto done = readSkin(node, parts, mesh.points, shape); !done) return done.error();
    }
    measure(shape);
    return shape;
  }

 private:
  /// For each vertex, a value of the first point that became it; fails where points that are one
  /// vertex differ.
  template <class T, class Same>
  Result<std::vector<T>> ofVertices(const std::vector<T>& ofPoints, const FilePoints& points,
                                    std::size_t vertices, const Place& where,
                                    const Same& same) const {
    std::vector<T> result(vertices);
    std::vector<std::uint32_t> pointOf(vertices, FilePoints::kUnused);
    for (std::uint32_t i = 0; i < ofPoints.size(); ++i) {
      const std::uint32_t vertex = points.vertexOf[i];
      if (vertex == FilePoints::kUnused) continue;
      if (pointOf[vertex] == FilePoints::kUnused) {
        pointOf[vertex] = i;
        result[vertex] = ofPoints[i];
      } else if (!same(result[vertex], ofPoints[i])) {
        return invalid(fmt::format("points {} and {} (counted from 0) are one vertex of the mesh, "
                                   "but move apart: the surface would tear",
                                   pointOf[vertex], i),
                       where);
      }
    }
    return result;
  }

  Result<void> readTargets(const tinygltf::Node& node, std::span<const GltfGeometry::Part> parts,
                           const FilePoints& points, GltfShape& shape) const {
    const auto count = static_cast<std::size_t>(gltfTargetCount(model_, node.mesh));
    if (count == 0) return {};
    const Place where = gltfElement(file_, "meshes", node.mesh);
    const auto& mesh = model_.meshes[static_cast<std::size_t>(node.mesh)];
    const auto& weights = node.weights.empty() ? mesh.weights : node.weights;
    if (!weights.empty() && weights.size() != count) {
      return invalid(fmt::format("has {} morph targets and {} weights", count, weights.size()),
                     where);
    }
    shape.weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(count));
    for (std::size_t k = 0; k < weights.size(); ++k) {
      shape.weights[static_cast<Eigen::Index>(k)] = weights[k];
    }
    for (std::size_t k = 0; k < count; ++k) {
      std::vector<Point3> displaced;
      double longest = 0;
      for (const auto& [primitive, pointCount, linear] : parts) {
        std::vector<double> numbers(3 * pointCount, 0.0);
        const bool has =
            k < primitive->targets.size() && primitive->targets[k].contains("POSITION");
        if (has) {
          const int accessor = primitive->targets[k].at("POSITION");
          auto read = readGltfAccessor(file_, model_, accessor, 3);
          if (!read) return read.error();
          if (read->size() != numbers.size()) {
            return invalid(
                fmt::format("{} displacements of {} positions", read->size() / 3, pointCount),
                gltfElement(file_, "accessors", accessor));
          }
          numbers = std::move(*read);
        }
        for (std::size_t i = 0; i < pointCount; ++i) {
          displaced.emplace_back(linear * Eigen::Map<const Point3>(&numbers[3 * i]));
          if (!displaced.back().allFinite()) {
            return invalid(fmt::format("morph target {} displaces a vertex by a number that is "
                                       "not finite",
                                       k),
                           where);
          }
          longest = std::max(longest, displaced.back().norm());
        }
      }
      auto target = ofVertices(
          displaced, points, shape.base.size(), where,
          [&](const Point3& a, const Point3& b) { return (a - b).norm() <= kTogether * longest; });
      if (!target) return target.error();
      shape.targets.push_back(std::move(*target));
    }
    return {};
  }

  Result<void> readSkin(const tinygltf::Node& node, std::span<const GltfGeometry::Part> parts,
                        const FilePoints& points, GltfShape& shape) const {
    const Place where = gltfElement(file_, "skins", node.skin);
    const auto* skin = elementAt(model_.skins, node.skin);
    if (skin == nullptr) return invalid("does not exist", where);
    std::vector<double> inverseBinds;
    if (skin->inverseBindMatrices >= 0) {
      auto read = readGltfAccessor(file_, model_, skin->inverseBindMatrices, 16);
      if (!read) return read.error();
      if (read->size() < 16 * skin->joints.size()) {
        return invalid(fmt::format("has {} joints and {} inverse bind matrices",
                                   skin->joints.size(), read->size() / 16),
                       where);
      }
      inverseBinds = std::move(*read);
    }
    for (std::size_t j = 0; j < skin->joints.size(); ++j) {
      if (!hierarchy_.has(skin->joints[j])) {
        return invalid(
            fmt::format("joint {} is node {}, which is not in the scene", j, skin->joints[j]),
            where);
      }
      GltfJoint joint{skin->joints[j], Affine3d::Identity()};
      if (!inverseBinds.empty()) {
        joint.inverseBind.matrix() = Eigen::Map<const Eigen::Matrix4d>(&inverseBinds[16 * j]);
        if (!joint.inverseBind.matrix().allFinite() ||
            joint.inverseBind.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
          return invalid(fmt::format("inverse bind matrix {} is not affine", j), where);
        }
      }
      shape.joints.push_back(joint);
    }
    std::vector<std::vector<GltfInfluence>> influences;
    for (const auto& [primitive, pointCount, linear] : parts) {
      std::vector<std::vector<GltfInfluence>> ofPart(pointCount);
      if (auto done = addGltfInfluences(*primitive, skin->joints.size(), where, ofPart); !done) {
        return done;
      }
      std::ranges::move(ofPart, std::back_inserter(influences));
    }
    auto read =
        ofVertices(influences, points, shape.base.size(), where, [](const auto& a, const auto& b) {
          return std::ranges::equal(a, b, [](auto& x, auto& y) {
            return x.joint == y.joint && std::abs(x.weight - y.weight) <= kTogether;
          });
        });
    if (!read) return read.error();
    shape.influences = std::move(*read);
    return {};
  }

  /// All sets of joints and weights, by joint, without zeros, with the sum 1.
  Result<void> addGltfInfluences(const tinygltf::Primitive& primitive, std::size_t joints,
                                 const Place& where,
                                 std::vector<std::vector<GltfInfluence>>& ofPoints) const {
    for (int set = 0;; ++set) {
      const auto jointsOf = primitive.attributes.find(fmt::format("JOINTS_{}", set));
      const auto weightsOf = primitive.attributes.find(fmt::format("WEIGHTS_{}", set));
      if (jointsOf == primitive.attributes.end() || weightsOf == primitive.attributes.end()) break;
      const auto joint = readGltfAccessor(file_, model_, jointsOf->second, 4);
      if (!joint) return joint.error();
      const auto weight = readGltfAccessor(file_, model_, weightsOf->second, 4);
      if (!weight) return weight.error();
      if (joint->size() != 4 * ofPoints.size() || weight->size() != 4 * ofPoints.size()) {
        return invalid(fmt::format("{} joints and {} weights of {} positions", joint->size() / 4,
                                   weight->size() / 4, ofPoints.size()),
                       where);
      }
      for (std::size_t i = 0; i < joint->size(); ++i) {
        if (!std::isfinite((*weight)[i])) return invalid("a weight that is not finite", where);
        if ((*weight)[i] == 0) continue;
        const double number = (*joint)[i];
        if (!(number >= 0 && number < static_cast<double>(joints))) {
          return invalid(
              fmt::format("a vertex refers to joint {}, but there are {}", number, joints), where);
        }
        ofPoints[i / 4].push_back({static_cast<std::uint32_t>(number), (*weight)[i]});
      }
    }
    for (auto& all : ofPoints) {
      std::ranges::stable_sort(all, {}, &GltfInfluence::joint);
      double sum = 0;
      for (const GltfInfluence& one : all) sum += one.weight;
      if (!(sum > 0)) return invalid("a vertex has no weight", where);
      for (GltfInfluence& one : all) one.weight /= sum;
    }
    return {};
  }

  /// Displacements (of the longest) and weights that differ by less are the same.
  static constexpr double kTogether = 1e-4;

  const InputFile& file_;
  const tinygltf::Model& model_;
  const GltfHierarchy& hierarchy_;
};

}  // namespace

void GltfShape::place(const GltfHierarchy& hierarchy, double time, Side side,
                      std::span<Point3> into) const {
  const std::vector<Point3> points = morphed(*this, time, side);
  if (joints.empty()) {
    const Affine3d world = hierarchy.world(node, time, side);
    for (std::size_t i = 0; i < points.size(); ++i) into[i] = world * points[i];
    return;
  }
  std::vector<Affine3d> matrices;
  for (const GltfJoint& joint : joints) {
    matrices.push_back(hierarchy.world(joint.node, time, side) * joint.inverseBind);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    into[i].setZero();
    for (const auto& [joint, weight] : influences[i]) {
      into[i] += weight * (matrices[joint] * points[i]);
    }
  }
}

double GltfShape::accelerationBound(const GltfHierarchy& hierarchy, double begin,
                                    double end) const {
  CurveBound displaced;
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    CurveBound weight;
    if (weightCurve == nullptr) {
      weight.value = std::abs(weights[row]);
    } else {
      const auto hull = weightCurve->hull(begin, end);
      weight = {hull.value.row(row).cwiseAbs().maxCoeff(),
                hull.first.row(row).cwiseAbs().maxCoeff(),
                hull.second.row(row).cwiseAbs().maxCoeff()};
    }
    displaced = displaced + weight * CurveBound{targetReach[k], 0, 0};
  }
  if (joints.empty()) {
    return hierarchy.bound(node, CurveBound{baseReach, 0, 0} + displaced, begin, end).second;
  }
  // A vertex is the mean of its places by the joints, whose weights have the sum 1.
  double largest = 0;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto& [node, inverseBind] = joints[j];
    const double stretch = inverseBind.linear().jacobiSvd().singularValues()[0];
    const CurveBound point =
        CurveBound{jointReach[j], 0, 0} + CurveBound{stretch, 0, 0} * displaced;
    largest = std::max(largest, hierarchy.bound(node, point, begin, end).second);
  }
  return heaviest * largest;
}

Result<GltfShape> readGltfShape(const InputFile& file, const tinygltf::Model& model,
                                const GltfHierarchy& hierarchy, int node,
                                std::span<const GltfGeometry::Part> parts, const LoadedMesh& mesh) {
  return ShapeReader(file, model, hierarchy).read(node, parts, mesh);
}

}  // namespace t4d::formats
