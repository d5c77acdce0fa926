#include "t4d/formats/gltf_animation.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include <Eigen/SVD>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "t4d/formats/gltf_curve.h"
#include "t4d/formats/gltf_geometry.h"
#include "t4d/formats/gltf_instances.h"
#include "t4d/formats/gltf_losses.h"
#include "t4d/formats/gltf_scene.h"
#include "t4d/formats/t4d/names.h"
#include "t4d/model/times.h"

namespace t4d::formats {
namespace {

using Eigen::Affine3d;
using model::Point3;
using Side = GltfCurve::Side;

/// More keys of a body, an hour of 55 a second, would be an attack or a tolerance mistyped.
constexpr std::size_t kMostKeys = 200'000;

/// A node and the curves that move it.
struct Node {
  int parent = -1;
  Affine3d local;  // at rest
  Point3 translation = Point3::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Point3 scale = Point3::Ones();
  const GltfCurve* translations = nullptr;
  const GltfCurve* rotations = nullptr;
  const GltfCurve* scales = nullptr;

  bool moves() const {
    return translations != nullptr || rotations != nullptr || scales != nullptr;
  }

  Affine3d at(double time, Side side) const {
    if (!moves()) return local;
    Affine3d transform = Affine3d::Identity();
    transform.translation() =
        translations != nullptr ? Point3(translations->at(time, side)) : translation;
    const Eigen::Quaterniond turn =
        rotations != nullptr ? Eigen::Quaterniond(Eigen::Vector4d(rotations->at(time, side)))
                             : rotation;
    const Point3 factors = scales != nullptr ? Point3(scales->at(time, side)) : scale;
    transform.linear() = turn.toRotationMatrix() * factors.asDiagonal();
    return transform;
  }

  /// Of the place of a point that moves within this node's coordinates: x -> T + R S x.
  CurveBound bound(const CurveBound& point, double begin, double end) const {
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
};

struct Joint {
  int node = 0;
  Affine3d inverseBind = Affine3d::Identity();
};

struct Influence {
  std::uint32_t joint = 0;
  double weight = 0;
};

/// What becomes of the vertices of a node's mesh.
struct Shape {
  int node = 0;
  std::vector<Point3> base;
  std::vector<std::vector<Point3>> targets;  // displacements of all vertices
  Eigen::VectorXd weights;                   // of the targets, at rest
  const GltfCurve* weightCurve = nullptr;
  std::vector<Joint> joints;                       // none without a skin
  std::vector<std::vector<Influence>> influences;  // of each vertex

  // For bounds: the largest distances from the origin, of the vertices, of each target's
  // displacements, and of the vertices that hang on each joint, in its coordinates.
  double baseReach = 0;
  std::vector<double> targetReach;
  std::vector<double> jointReach;
  double heaviest = 1;  // the largest sum of the magnitudes of a vertex's weights

  bool deforms() const { return !joints.empty() || !targets.empty(); }
  void measure();
};

double reachOf(const std::vector<Point3>& points) {
  double length = 0;
  for (const Point3& point : points) length = std::max(length, point.norm());
  return length;
}

void Shape::measure() {
  baseReach = reachOf(base);
  for (const auto& target : targets) targetReach.push_back(reachOf(target));
  jointReach.assign(joints.size(), 0);
  for (std::size_t i = 0; i < influences.size(); ++i) {
    double sum = 0;
    for (const auto& [joint, weight] : influences[i]) {
      jointReach[joint] = std::max(jointReach[joint], (joints[joint].inverseBind * base[i]).norm());
      sum += std::abs(weight);
    }
    heaviest = std::max(heaviest, sum);
  }
}

/// Everything that moves; the curves and nodes do not change after it has been read.
struct Moving {
  std::vector<std::unique_ptr<GltfCurve>> curves;
  std::vector<std::optional<Node>> nodes;  // by their index; nothing outside the scene

  const Node& node(int index) const { return *nodes[static_cast<std::size_t>(index)]; }

  Affine3d world(int index, double time, Side side) const {
    Affine3d transform = node(index).at(time, side);
    for (int i = node(index).parent; i >= 0; i = node(i).parent) {
      transform = node(i).at(time, side) * transform;
    }
    return transform;
  }

  CurveBound bound(int index, CurveBound point, double begin, double end) const {
    for (int i = index; i >= 0; i = node(i).parent) point = node(i).bound(point, begin, end);
    return point;
  }
};

std::vector<Point3> morphed(const Shape& shape, double time, Side side) {
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

void place(const Moving& moving, const Shape& shape, double time, Side side,
           std::span<Point3> into) {
  const std::vector<Point3> points = morphed(shape, time, side);
  if (shape.joints.empty()) {
    const Affine3d world = moving.world(shape.node, time, side);
    for (std::size_t i = 0; i < points.size(); ++i) into[i] = world * points[i];
    return;
  }
  std::vector<Affine3d> matrices;
  for (const Joint& joint : shape.joints) {
    matrices.push_back(moving.world(joint.node, time, side) * joint.inverseBind);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    into[i].setZero();
    for (const auto& [joint, weight] : shape.influences[i]) {
      into[i] += weight * (matrices[joint] * points[i]);
    }
  }
}

/// A bound of the second derivative of every vertex's place over an interval without keys inside.
double accelerationBound(const Moving& moving, const Shape& shape, double begin, double end) {
  CurveBound displaced;
  for (std::size_t k = 0; k < shape.targets.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    CurveBound weight;
    if (shape.weightCurve == nullptr) {
      weight.value = std::abs(shape.weights[row]);
    } else {
      const auto hull = shape.weightCurve->hull(begin, end);
      weight = {hull.value.row(row).cwiseAbs().maxCoeff(),
                hull.first.row(row).cwiseAbs().maxCoeff(),
                hull.second.row(row).cwiseAbs().maxCoeff()};
    }
    displaced = displaced + weight * CurveBound{shape.targetReach[k], 0, 0};
  }
  if (shape.joints.empty()) {
    return moving.bound(shape.node, CurveBound{shape.baseReach, 0, 0} + displaced, begin, end)
        .second;
  }
  // A vertex is the mean of its places by the joints, whose weights have the sum 1.
  double largest = 0;
  for (std::size_t j = 0; j < shape.joints.size(); ++j) {
    const auto& [node, inverseBind] = shape.joints[j];
    const double stretch = inverseBind.linear().jacobiSvd().singularValues()[0];
    const CurveBound point =
        CurveBound{shape.jointReach[j], 0, 0} + CurveBound{stretch, 0, 0} * displaced;
    largest = std::max(largest, moving.bound(node, point, begin, end).second);
  }
  return shape.heaviest * largest;
}

/// A body from one jump to the next.
class Run : public model::VertexKeys {
 public:
  Run(std::shared_ptr<const Moving> moving, std::shared_ptr<const Shape> shape,
      std::vector<double> times, bool mirrored)
      : moving_(std::move(moving)),
        shape_(std::move(shape)),
        times_(std::move(times)),
        mirrored_(mirrored) {}

  std::uint64_t count() const override { return times_.size(); }
  double time(std::uint64_t key) const override { return times_[key]; }

  std::optional<model::Affine3x4> pose(std::uint64_t key) const override {
    if (shape_->deforms()) return std::nullopt;
    Affine3d world = moving_->world(shape_->node, times_[key], sideOf(key));
    if (mirrored_) world = world * Eigen::Scaling(-1.0, 1.0, 1.0);
    return world.matrix().topRows<3>();
  }

  Result<void> positions(std::uint64_t key, std::span<Point3> into) const override {
    if (const auto matrix = pose(key)) {
      for (std::size_t i = 0; i < into.size(); ++i) {
        const Point3& p = shape_->base[i];
        into[i] = model::posed(*matrix, mirrored_ ? Point3(-p.x(), p.y(), p.z()) : p);
      }
    } else {
      place(*moving_, *shape_, times_[key], sideOf(key), into);
    }
    return {};
  }

 private:
  Side sideOf(std::uint64_t key) const {
    return key + 1 == times_.size() ? Side::Before : Side::Behind;
  }

  std::shared_ptr<const Moving> moving_;
  std::shared_ptr<const Shape> shape_;
  std::vector<double> times_;
  bool mirrored_;  // the mesh is the mirror image of the shape in x = 0
};

/// The number of the element of that name, or of that number.
template <class T>
Result<int> chosen(const std::vector<T>& all, const std::string& wanted, const char* kind,
                   const std::string& file) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == wanted) return static_cast<int>(i);
  }
  std::size_t number = 0;
  const auto end = wanted.data() + wanted.size();
  const auto [stop, problem] = std::from_chars(wanted.data(), end, number);
  if (problem == std::errc{} && stop == end && number < all.size()) {
    return static_cast<int>(number);
  }
  std::vector<std::string> names;
  for (std::size_t i = 0; i < all.size(); ++i) {
    names.push_back(all[i].name.empty() ? std::to_string(i) : "'" + all[i].name + "'");
  }
  return invalid(fmt::format("has no {} '{}'; it has {}", kind, wanted,
                             names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))),
                 file);
}

class AnimationReader {
 public:
  AnimationReader(const InputFile& file, const tinygltf::Model& model,
                  const GltfAnimationOptions& options)
      : file_(file), model_(model), options_(options) {}

  Result<AnimatedScene> read() {
    if (auto done = choose(); !done) return pass(done.error());
    if (auto done = readNodes(); !done) return pass(done.error());
    if (auto done = readChannels(); !done) return pass(done.error());
    if (auto done = checkScales(); !done) return pass(done.error());
    if (auto done = readShapes(); !done) return pass(done.error());
    if (auto done = chooseTolerance(); !done) return pass(done.error());
    std::size_t hidden = 0;
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      auto runs = runsOf(i);
      if (!runs) return pass(runs.error());
      hidden += runs->empty();
      scene_.bodies[i].runs = std::move(*runs);
    }
    std::erase_if(scene_.bodies, [](const AnimatedBody& body) { return body.runs.empty(); });
    if (scene_.bodies.empty()) {
      return invalid("holds no mesh that is visible in the scene", file_.path.string());
    }
    if (hidden > 0) {
      scene_.notices.push_back(fmt::format("left out {}, whose scale is zero all the time",
                                           counted(hidden, "hidden node")));
    }
    if (hiddenInstances_ > 0) {
      scene_.notices.push_back(fmt::format("left out {}, whose scale is zero",
                                           counted(hiddenInstances_, "hidden instance")));
    }
    scene_.losses = gltfLosses(model_, used_);
    if (otherChannels_ > 0) {
      scene_.losses.push_back(fmt::format("{} of the animation that move neither nodes nor weights",
                                          counted(otherChannels_, "channel")));
    }
    return std::move(scene_);
  }

 private:
  Result<void> choose() {
    const std::string file = file_.path.string();
    if (model_.animations.empty()) return invalid("has no animation", file);
    if (!options_.animation.empty()) {
      const auto found = chosen(model_.animations, options_.animation, "animation", file);
      if (!found) return pass(found.error());
      animation_ = *found;
    }
    used_.animation = animation_;
    if (!options_.scene.empty()) {
      const auto found = chosen(model_.scenes, options_.scene, "scene", file);
      if (!found) return pass(found.error());
      used_.scene = *found;
    }
    return {};
  }

  Result<void> readNodes() {
    auto scene = readGltfScene(file_, model_, used_.scene);
    if (!scene) return pass(scene.error());
    order_ = std::move(scene->nodes);
    moving_->nodes.resize(model_.nodes.size());
    for (const GltfNode& node : order_) {
      const auto& from = model_.nodes[static_cast<std::size_t>(node.index)];
      Node made;
      made.parent = node.parent;
      made.local = node.local;
      made.translation = node.local.translation();
      if (!from.rotation.empty()) {
        made.rotation = Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(from.rotation.data()));
        made.rotation.normalize();
      }
      if (!from.scale.empty()) made.scale = Eigen::Map<const Point3>(from.scale.data());
      moving_->nodes[static_cast<std::size_t>(node.index)] = made;
    }
    return {};
  }

  std::optional<Node>* nodeAt(int index) {
    const bool exists = index >= 0 && static_cast<std::size_t>(index) < moving_->nodes.size();
    auto* node = exists ? &moving_->nodes[static_cast<std::size_t>(index)] : nullptr;
    return node != nullptr && node->has_value() ? node : nullptr;
  }

  Result<void> readChannels() {
    const auto& animation = model_.animations[static_cast<std::size_t>(animation_)];
    weightCurves_.resize(model_.nodes.size(), nullptr);
    for (std::size_t i = 0; i < animation.channels.size(); ++i) {
      const auto& channel = animation.channels[i];
      const std::string where =
          fmt::format("{}.channels[{}]", gltfElement(file_, "animations", animation_), i);
      auto* node = nodeAt(channel.target_node);
      const std::string& path = channel.target_path;
      const bool known =
          path == "translation" || path == "rotation" || path == "scale" || path == "weights";
      if (!known) ++otherChannels_;
      if (channel.target_node >= static_cast<int>(model_.nodes.size())) {
        return invalid(fmt::format("moves node {}, which does not exist; there are {}",
                                   channel.target_node, model_.nodes.size()),
                       where);
      }
      // What is not in the scene does not move anything.
      if (!known || node == nullptr) continue;
      const auto& target = model_.nodes[static_cast<std::size_t>(channel.target_node)];
      const GltfCurve*& slot = path == "translation" ? (*node)->translations
                               : path == "rotation"  ? (*node)->rotations
                               : path == "scale"
                                   ? (*node)->scales
                                   : weightCurves_[static_cast<std::size_t>(channel.target_node)];
      if (slot != nullptr) {
        return invalid(fmt::format("moves the {} of node {}, as another channel does", path,
                                   channel.target_node),
                       where);
      }
      if (!target.matrix.empty() && path != "weights") {
        return invalid(fmt::format("moves node {}, which has a matrix", channel.target_node),
                       where);
      }
      const auto kind = path == "rotation"  ? GltfCurve::Kind::Rotation
                        : path == "weights" ? GltfCurve::Kind::Weights
                                            : GltfCurve::Kind::Vector;
      const int width = kind == GltfCurve::Kind::Rotation  ? 4
                        : kind == GltfCurve::Kind::Weights ? targetCount(target.mesh)
                                                           : 3;
      if (width == 0) {
        return invalid(fmt::format("moves the weights of node {}, whose mesh has no morph targets",
                                   channel.target_node),
                       where);
      }
      auto curve = GltfCurve::read(file_, model_, animation_, channel.sampler, kind, width);
      if (!curve) return pass(curve.error());
      end_ = std::max(end_, curve->times().back());
      moving_->curves.push_back(std::make_unique<GltfCurve>(std::move(*curve)));
      slot = moving_->curves.back().get();
    }
    if (end_ > 0) return {};
    return invalid("has no key after time 0 that moves a node of the scene, so nothing moves",
                   gltfElement(file_, "animations", animation_));
  }

  /// A solid that shrinks to nothing, or through it, is no solid there.
  Result<void> checkScales() const {
    for (std::size_t i = 0; i < moving_->nodes.size(); ++i) {
      if (!moving_->nodes[i] || moving_->nodes[i]->scales == nullptr) continue;
      const GltfCurve& scales = *moving_->nodes[i]->scales;
      for (std::size_t key = 1; key < scales.times().size(); ++key) {
        const double begin = scales.times()[key - 1];
        const double end = scales.times()[key];
        if (!shrinksToZero(scales, begin, end, 0)) continue;
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

  int targetCount(int mesh) const {
    const auto* found = elementAt(model_.meshes, mesh);
    std::size_t count = 0;
    if (found == nullptr) return 0;
    for (const auto& primitive : found->primitives) {
      count = std::max(count, primitive.targets.size());
    }
    return static_cast<int>(count);
  }

  Result<void> readShapes() {
    std::vector<GltfCopies> copies;
    for (const GltfNode& node : order_) {
      const int mesh = model_.nodes[static_cast<std::size_t>(node.index)].mesh;
      if (mesh < 0) continue;
      const auto count = countGltfInstances(file_, model_, node.index);
      if (!count) return pass(count.error());
      copies.push_back({mesh, *count});
    }
    if (auto good = checkGltfCost(file_, model_, copies); !good) return good;
    for (const GltfNode& node : order_) {
      const auto& from = model_.nodes[static_cast<std::size_t>(node.index)];
      if (from.mesh < 0) continue;
      used_.meshes.insert(from.mesh);
      for (int i = node.index; i >= 0 && used_.nodes.insert(i).second;) i = moving_->node(i).parent;
      if (auto done = readShape(node.index, from); !done) return done;
    }
    return {};
  }

  Result<void> readShape(int index, const tinygltf::Node& node) {
    GltfGeometry geometry(file_, model_);
    if (auto added = addInstances(index, node, geometry); !added) return added;
    if (geometry.parts().empty()) return {};
    const auto parts = geometry.parts();
    auto loaded = std::move(geometry).finish();
    if (!loaded) {
      loaded.error().where = gltfElement(file_, "meshes", node.mesh);
      return pass(loaded.error());
    }
    auto shape = std::make_shared<Shape>();
    shape->node = index;
    shape->base = loaded->mesh.vertices;
    shape->weightCurve = weightCurves_[static_cast<std::size_t>(index)];
    if (auto done = readTargets(node, parts, loaded->points, *shape); !done) return done;
    if (node.skin >= 0) {
      if (auto done = readSkin(node, parts, loaded->points, *shape); !done) return done;
    }
    shape->measure();
    AnimatedBody body{nameFor(index, node), std::move(loaded->mesh), {}};
    for (const std::string& notice : loaded->notices) {
      scene_.notices.push_back(fmt::format("body '{}': {}", body.name, notice));
    }
    const bool mirrored = shape->joints.empty() && mirrors(index);
    mirrored_.push_back(mirrored);
    if (mirrored) {
      for (model::Triangle& triangle : body.mesh.triangles) std::swap(triangle[1], triangle[2]);
      if (!shape->deforms()) {
        for (Point3& p : body.mesh.vertices) p.x() = -p.x();
      }
    }
    scene_.bodies.push_back(std::move(body));
    shapes_.push_back(std::move(shape));
    return {};
  }

  Result<void> addInstances(int index, const tinygltf::Node& node, GltfGeometry& geometry) {
    const auto instances = readGltfInstances(file_, model_, index);
    if (!instances) return pass(instances.error());
    if (node.skin >= 0 && !gltfInstanceAttributes(node).empty()) {
      return fail(ErrorCode::Unsupported,
                  "has a skin and instances (EXT_mesh_gpu_instancing), which glTF does not define "
                  "together",
                  gltfElement(file_, "nodes", index));
    }
    for (const Affine3d& instance : *instances) {
      if (instance.linear().isZero(0)) {
        ++hiddenInstances_;
      } else if (auto added = geometry.addMesh(node.mesh, instance); !added) {
        return added;
      }
    }
    return {};
  }

  /// At the first time at which the node has a size.
  bool mirrors(int index) const {
    std::set<double> times = {0, end_};
    for (int i = index; i >= 0; i = moving_->node(i).parent) {
      if (const GltfCurve* scales = moving_->node(i).scales) {
        times.insert(scales->times().begin(), scales->times().end());
      }
    }
    double before = 0;
    for (const double time : times) {
      for (const double t : {before / 2 + time / 2, time}) {
        const double factor = moving_->world(index, t, Side::Behind).linear().determinant();
        if (factor != 0) return factor < 0;
      }
      before = time;
    }
    return false;
  }

  std::string nameFor(int index, const tinygltf::Node& node) {
    const auto* mesh = elementAt(model_.meshes, node.mesh);
    std::string name = !node.name.empty()    ? node.name
                       : !mesh->name.empty() ? mesh->name
                                             : fmt::format("node {}", index);
    name = asName(name);
    std::string unique = name;
    for (int i = 2; !names_.insert(unique).second; ++i) unique = fmt::format("{} {}", name, i);
    return unique;
  }

  /// For each vertex, a value of the first point that became it; fails where points that are one
  /// vertex differ.
  template <class T, class Same>
  Result<std::vector<T>> ofVertices(const std::vector<T>& ofPoints, const FilePoints& points,
                                    std::size_t vertices, const std::string& where,
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

  Result<void> readTargets(const tinygltf::Node& node, const std::vector<GltfGeometry::Part>& parts,
                           const FilePoints& points, Shape& shape) const {
    const auto count = static_cast<std::size_t>(targetCount(node.mesh));
    if (count == 0) return {};
    const std::string where = gltfElement(file_, "meshes", node.mesh);
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
          if (!read) return pass(read.error());
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
      if (!target) return pass(target.error());
      shape.targets.push_back(std::move(*target));
    }
    return {};
  }

  Result<void> readSkin(const tinygltf::Node& node, const std::vector<GltfGeometry::Part>& parts,
                        const FilePoints& points, Shape& shape) {
    const std::string where = gltfElement(file_, "skins", node.skin);
    const auto* skin = elementAt(model_.skins, node.skin);
    if (skin == nullptr) return invalid("does not exist", where);
    std::vector<double> inverseBinds;
    if (skin->inverseBindMatrices >= 0) {
      auto read = readGltfAccessor(file_, model_, skin->inverseBindMatrices, 16);
      if (!read) return pass(read.error());
      if (read->size() < 16 * skin->joints.size()) {
        return invalid(fmt::format("has {} joints and {} inverse bind matrices",
                                   skin->joints.size(), read->size() / 16),
                       where);
      }
      inverseBinds = std::move(*read);
    }
    for (std::size_t j = 0; j < skin->joints.size(); ++j) {
      if (nodeAt(skin->joints[j]) == nullptr) {
        return invalid(
            fmt::format("joint {} is node {}, which is not in the scene", j, skin->joints[j]),
            where);
      }
      Joint joint{skin->joints[j], Affine3d::Identity()};
      if (!inverseBinds.empty()) {
        joint.inverseBind.matrix() = Eigen::Map<const Eigen::Matrix4d>(&inverseBinds[16 * j]);
        if (!joint.inverseBind.matrix().allFinite() ||
            joint.inverseBind.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
          return invalid(fmt::format("inverse bind matrix {} is not affine", j), where);
        }
      }
      shape.joints.push_back(joint);
    }
    std::vector<std::vector<Influence>> influences;
    for (const auto& [primitive, pointCount, linear] : parts) {
      std::vector<std::vector<Influence>> ofPart(pointCount);
      if (auto done = addInfluences(*primitive, skin->joints.size(), where, ofPart); !done) {
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
    if (!read) return pass(read.error());
    shape.influences = std::move(*read);
    return {};
  }

  /// All sets of joints and weights, by joint, without zeros, with the sum 1.
  Result<void> addInfluences(const tinygltf::Primitive& primitive, std::size_t joints,
                             const std::string& where,
                             std::vector<std::vector<Influence>>& ofPoints) const {
    for (int set = 0;; ++set) {
      const auto jointsOf = primitive.attributes.find(fmt::format("JOINTS_{}", set));
      const auto weightsOf = primitive.attributes.find(fmt::format("WEIGHTS_{}", set));
      if (jointsOf == primitive.attributes.end() || weightsOf == primitive.attributes.end()) break;
      const auto joint = readGltfAccessor(file_, model_, jointsOf->second, 4);
      if (!joint) return pass(joint.error());
      const auto weight = readGltfAccessor(file_, model_, weightsOf->second, 4);
      if (!weight) return pass(weight.error());
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
      std::ranges::stable_sort(all, {}, &Influence::joint);
      double sum = 0;
      for (const Influence& one : all) sum += one.weight;
      if (!(sum > 0)) return invalid("a vertex has no weight", where);
      for (Influence& one : all) one.weight /= sum;
    }
    return {};
  }

  Result<void> chooseTolerance() {
    double largest = 0;
    for (const auto& shape : shapes_) {
      std::vector<Point3> positions(shape->base.size());
      // A node that is hidden at first has its size later.
      for (const double time : {0.0, end_ / 2, end_}) {
        place(*moving_, *shape, time, Side::Behind, positions);
        model::Bounds3 bounds;
        for (const Point3& position : positions) bounds.add(position);
        largest = std::max(largest, (bounds.max - bounds.min).maxCoeff());
      }
    }
    scene_.tolerance = options_.tolerance.value_or(largest / 1000);
    if (scene_.tolerance > 0 && std::isfinite(scene_.tolerance)) return {};
    if (!options_.tolerance) {
      return invalid(
          "has no solid with a size at its first, middle and last time, from which a "
          "tolerance could be taken; give one",
          file_.path.string());
    }
    return invalid(
        fmt::format("the tolerance is {}; it must be a positive length", scene_.tolerance),
        file_.path.string());
  }

  /// The curves that move a shape.
  std::set<const GltfCurve*> curvesOf(const Shape& shape) const {
    std::set<const GltfCurve*> curves;
    const auto addChain = [&](int index) {
      for (int i = index; i >= 0; i = moving_->node(i).parent) {
        const Node& node = moving_->node(i);
        for (const GltfCurve* curve : {node.translations, node.rotations, node.scales}) {
          curves.insert(curve);
        }
      }
    };
    if (shape.joints.empty()) addChain(shape.node);
    for (const Joint& joint : shape.joints) addChain(joint.node);
    curves.insert(shape.weightCurve);
    curves.erase(nullptr);
    return curves;
  }

  Result<std::vector<std::unique_ptr<model::VertexKeys>>> runsOf(std::size_t body) {
    const std::shared_ptr<const Shape>& shape = shapes_[body];
    keys_ = 0;
    std::set<double> keys = {0, end_};
    std::set<double> jumps = {0, end_};
    for (const GltfCurve* curve : curvesOf(*shape)) {
      keys.insert(curve->times().begin(), curve->times().end());
      const auto found = curve->jumps();
      jumps.insert(found.begin(), found.end());
    }
    std::vector<std::unique_ptr<model::VertexKeys>> runs;
    for (auto jump = jumps.begin(); std::next(jump) != jumps.end(); ++jump) {
      const double begin = *jump;
      const double end = *std::next(jump);
      if (isHidden(*shape, begin, end)) continue;
      std::vector<double> times = {begin};
      for (auto key = keys.upper_bound(begin); key != keys.end() && *key <= end; ++key) {
        if (auto done = divide(*shape, {times.back(), *key}, times); !done) {
          return pass(done.error());
        }
      }
      runs.push_back(std::make_unique<Run>(moving_, shape, std::move(times), mirrored_[body]));
    }
    return runs;
  }

  bool isHidden(const Shape& shape, double begin, double end) const {
    if (!shape.joints.empty()) return false;
    const auto isZero = [&](double time, Side side) {
      return moving_->world(shape.node, time, side).linear().isZero(0);
    };
    return isZero(begin, Side::Behind) && isZero(begin / 2 + end / 2, Side::Behind) &&
           isZero(end, Side::Before);
  }

  /// Adds the ends of steps that are short enough for the tolerance. Halves the span where its
  /// bound asks for many steps, since bounds of shorter spans are better.
  Result<void> divide(const Shape& shape, const model::TimeSpan& span, std::vector<double>& times) {
    constexpr double kManySteps = 8;
    const double duration = span.end - span.begin;
    const double acceleration = accelerationBound(*moving_, shape, span.begin, span.end);
    // Without a bound, products of infinities may be no number.
    const double steps =
        std::isfinite(acceleration)
            ? std::max(1.0, std::ceil(duration * std::sqrt(acceleration / (8 * scene_.tolerance))))
            : std::numeric_limits<double>::infinity();
    const double middle = model::dividedTime(span, 1, 2);
    if (!(steps <= kManySteps)) {
      if (!(middle > span.begin && middle < span.end)) {
        return invalid(fmt::format("turns too fast at time {}: a rotation passes through zero, or "
                                   "the tolerance of {} is too small",
                                   span.begin, scene_.tolerance),
                       gltfElement(file_, "animations", animation_));
      }
      if (auto done = divide(shape, {span.begin, middle}, times); !done) return done;
      return divide(shape, {middle, span.end}, times);
    }
    const auto count = static_cast<std::uint64_t>(steps);
    for (std::uint64_t i = 1; i <= count; ++i) {
      const double time = model::dividedTime(span, i, count);
      if (time > times.back()) times.push_back(time);
    }
    keys_ += count;
    if (keys_ <= kMostKeys) return {};
    return invalid(fmt::format("needs more than {} keys for the tolerance of {}; allow a larger "
                               "one",
                               kMostKeys, scene_.tolerance),
                   gltfElement(file_, "animations", animation_));
  }

  /// Displacements (of the longest) and weights that differ by less are the same.
  static constexpr double kTogether = 1e-4;

  const InputFile& file_;
  const tinygltf::Model& model_;
  const GltfAnimationOptions& options_;
  int animation_ = 0;
  double end_ = 0;
  std::size_t keys_ = 0;  // of the present body
  std::size_t otherChannels_ = 0;
  std::size_t hiddenInstances_ = 0;
  GltfUse used_;
  std::vector<GltfNode> order_;
  std::shared_ptr<Moving> moving_ = std::make_shared<Moving>();
  std::vector<const GltfCurve*> weightCurves_;
  std::vector<std::shared_ptr<const Shape>> shapes_;
  std::vector<bool> mirrored_;
  std::set<std::string> names_;
  AnimatedScene scene_;
};

}  // namespace

Result<AnimatedScene> readGltfAnimation(const InputFile& file,
                                        const GltfAnimationOptions& options) {
  auto loaded = loadGltfModel(file);
  if (!loaded) return pass(loaded.error());
  auto scene = AnimationReader(file, loaded->model, options).read();
  if (scene) scene->otherFiles = std::move(loaded->bufferFiles);
  return scene;
}

}  // namespace t4d::formats
