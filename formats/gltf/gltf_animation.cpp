#include "formats/gltf/gltf_animation.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/animation/key_divider.h"
#include "formats/animation/shape_run.h"
#include "formats/gltf/gltf_curve.h"
#include "formats/gltf/gltf_geometry.h"
#include "formats/gltf/gltf_hierarchy.h"
#include "formats/gltf/gltf_instances.h"
#include "formats/gltf/gltf_looks.h"
#include "formats/gltf/gltf_losses.h"
#include "formats/gltf/gltf_material_names.h"
#include "formats/gltf/gltf_scene.h"
#include "formats/gltf/gltf_shape.h"
#include "formats/t4d/names.h"
#include "model/amount_text.h"
#include "model/number.h"
#include "t4d/mesh.h"

namespace t4d::formats {
namespace {

using Eigen::Affine3d;
using model::Point3;
using Side = GltfCurve::Side;

/// A shape among the nodes that move it.
class Moving : public MovingShape {
 public:
  Moving(std::shared_ptr<const GltfHierarchy> hierarchy, std::shared_ptr<const GltfShape> shape)
      : hierarchy_(std::move(hierarchy)), shape_(std::move(shape)) {}

  void place(double time, bool atEnd, std::span<Point3> into) const override {
    shape_->place(*hierarchy_, time, sideOf(atEnd), into);
  }
  std::optional<Affine3d> pose(double time, bool atEnd) const override {
    if (shape_->deforms()) return std::nullopt;
    return hierarchy_->world(shape_->node, time, sideOf(atEnd));
  }
  double accelerationBound(double begin, double end) const override {
    return shape_->accelerationBound(*hierarchy_, begin, end);
  }

 private:
  static Side sideOf(bool atEnd) { return atEnd ? Side::Before : Side::Behind; }

  std::shared_ptr<const GltfHierarchy> hierarchy_;
  std::shared_ptr<const GltfShape> shape_;
};

void insertTimes(const GltfCurve& curve, std::set<double>& times) {
  const auto from0 = curve.timesFromZero();
  times.insert(from0.begin(), from0.end());
}

/// The number of the element of that name, or of that number.
template <class T>
Result<int> chosen(const std::vector<T>& all, const std::string& wanted, const char* kind,
                   const std::string& file) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == wanted) return static_cast<int>(i);
  }
  const auto number = model::numberIn<std::size_t>(wanted);
  if (number && *number < all.size()) return static_cast<int>(*number);
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
    if (auto done = choose(); !done) return done.error();
    if (auto done = readHierarchy(); !done) return done.error();
    if (auto done = readShapes(); !done) return done.error();
    if (auto done = chooseTolerances(); !done) return done.error();
    std::size_t hidden = 0;
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      auto runs = runsOf(i);
      if (!runs) return runs.error();
      hidden += runs->empty();
      scene_.bodies[i].runs = std::move(*runs);
    }
    std::erase_if(scene_.bodies, [](const AnimatedBody& body) { return body.runs.empty(); });
    if (scene_.bodies.empty()) {
      return invalid("holds no mesh that is visible in the scene", file_.path.string());
    }
    if (hidden > 0) {
      scene_.notices.push_back(fmt::format("left out {}: scale zero or not visible all the time",
                                           model::counted(hidden, "hidden node")));
    }
    if (hiddenInstances_ > 0) {
      scene_.notices.push_back(fmt::format("left out {}, whose scale is zero",
                                           model::counted(hiddenInstances_, "hidden instance")));
    }
    addHalfTurns();
    if (moving_->keysBeforeZero > 0) {
      scene_.notices.push_back(
          fmt::format("{} before time 0, where the animation begins",
                      model::counted(moving_->keysBeforeZero, "key is", "keys are")));
    }
    scene_.materials = materials_.names();
    used_.materialNames = !scene_.materials.empty();
    scene_.losses = gltfLosses(model_, used_);
    if (!moving_->others.empty()) {
      scene_.losses.push_back(fmt::format("the animation of {}: it neither moves nodes nor morphs",
                                          fmt::join(moving_->others, ", ")));
    }
    return std::move(scene_);
  }

 private:
  Result<void> choose() {
    const std::string file = file_.path.string();
    if (model_.animations.empty()) {
      return invalid("has no animation", file, Remedy::GiveMotion);
    }
    const int count = static_cast<int>(model_.animations.size());
    if (options_.animation.empty()) {
      animations_ = {0};
    } else if (const auto found =
                   chosen(model_.animations, options_.animation, "animation", file)) {
      animations_ = {*found};
    } else if (options_.animation == "all") {
      for (int i = 0; i < count; ++i) animations_.push_back(i);
    } else {
      return found.error();
    }
    used_.animated = true;
    for (int i = 0; i < count; ++i) {
      const std::string& name = model_.animations[static_cast<std::size_t>(i)].name;
      if (std::ranges::find(animations_, i) != animations_.end()) continue;
      scene_.otherAnimations.push_back(name.empty() ? std::to_string(i)
                                                    : fmt::format("'{}'", asName(name)));
    }
    if (!options_.scene.empty()) {
      const auto found = chosen(model_.scenes, options_.scene, "scene", file);
      if (!found) return found.error();
      used_.scene = *found;
    }
    return {};
  }

  Result<void> readHierarchy() {
    auto scene = readGltfScene(file_, model_, used_.scene);
    if (!scene) return scene.error();
    order_ = std::move(scene->nodes);
    auto hierarchy = readGltfHierarchy(file_, model_, order_, animations_);
    if (!hierarchy) return hierarchy.error();
    moving_ = std::make_shared<const GltfHierarchy>(std::move(*hierarchy));
    return {};
  }

  Result<void> readShapes() {
    std::vector<GltfCopies> copies;
    for (const GltfNode& node : order_) {
      const int mesh = model_.nodes[static_cast<std::size_t>(node.index)].mesh;
      if (mesh < 0) continue;
      const auto count = countGltfInstances(file_, model_, node.index);
      if (!count) return count.error();
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
    GltfLooks looks = readGltfLooks(file_, model_, parts);
    FileCorners corners;
    if (!looks.rows.empty()) geometry.keepCornersIn(corners);
    std::vector<std::uint32_t> partOf;
    geometry.keepPartsIn(partOf);
    auto loaded = std::move(geometry).finish();
    if (!loaded) {
      loaded.error().where = gltfElement(file_, "meshes", node.mesh);
      return loaded.error();
    }
    auto read = readGltfShape(file_, model_, *moving_, index, parts, *loaded);
    if (!read) return read.error();
    auto shape = std::make_shared<const GltfShape>(std::move(*read));
    AnimatedBody body{nameFor(index, node), std::move(loaded->mesh), {}};
    loaded->notices.insert(loaded->notices.end(), looks.notices.begin(), looks.notices.end());
    for (const std::string& notice : loaded->notices) {
      scene_.notices.push_back(fmt::format("body '{}': {}", body.name, notice));
    }
    const bool mirrored = shape->joints.empty() && mirrors(index);
    mirrored_.push_back(mirrored);
    if (mirrored) {
      for (model::Triangle& triangle : body.mesh.triangles) std::swap(triangle[1], triangle[2]);
      for (auto& triangle : corners.ofTriangles) std::swap(triangle[1], triangle[2]);
      if (!shape->deforms()) {
        for (Point3& p : body.mesh.vertices) p.x() = -p.x();
      }
    }
    for (const model::Attribute& rows : looks.rows) {
      body.mesh.attributes.push_back(cornerAttribute(rows, corners.points, corners, body.mesh));
    }
    materials_.addTo(body.mesh, parts, partOf);
    used_.attributes.merge(looks.names);
    scene_.bodies.push_back(std::move(body));
    shapes_.push_back(std::move(shape));
    return {};
  }

  Result<void> addInstances(int index, const tinygltf::Node& node, GltfGeometry& geometry) {
    const auto instances = readGltfInstances(file_, model_, index);
    if (!instances) return instances.error();
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

  /// Whether the node mirrors, at the first time at which it has a size.
  bool mirrors(int index) const {
    std::set<double> times = {0, moving_->end};
    for (int i = index; i >= 0; i = moving_->node(i).parent) {
      if (const GltfCurve* scales = moving_->node(i).scales) insertTimes(*scales, times);
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

  Result<void> chooseTolerances() {
    std::vector<double> extents;
    for (const auto& shape : shapes_) {
      const Moving moving(moving_, shape);
      extents.push_back(largestExtent(moving, shape->base.size(), {0, moving_->end}));
    }
    const auto tolerances = tolerancesOf(options_.tolerance, extents, file_.path.string());
    if (!tolerances) return tolerances.error();
    for (std::size_t i = 0; i < shapes_.size(); ++i) scene_.bodies[i].tolerance = (*tolerances)[i];
    return {};
  }

  /// The curves that move a shape.
  std::set<const GltfCurve*> curvesOf(const GltfShape& shape) const {
    std::set<const GltfCurve*> curves;
    const auto addChain = [&](int index) {
      for (int i = index; i >= 0; i = moving_->node(i).parent) {
        const GltfMovingNode& node = moving_->node(i);
        for (const GltfCurve* curve : {node.translations, node.rotations, node.scales}) {
          curves.insert(curve);
        }
      }
    };
    if (shape.joints.empty()) addChain(shape.node);
    for (const GltfJoint& joint : shape.joints) addChain(joint.node);
    for (int i = shape.node; i >= 0; i = moving_->node(i).parent) {
      curves.insert(moving_->node(i).visibles);
    }
    curves.insert(shape.weightCurve);
    curves.erase(nullptr);
    return curves;
  }

  Result<std::vector<std::unique_ptr<model::VertexKeys>>> runsOf(std::size_t body) {
    const std::shared_ptr<const GltfShape>& shape = shapes_[body];
    const auto moving = std::make_shared<const Moving>(moving_, shape);
    const model::TriangleMesh& mesh = scene_.bodies[body].mesh;
    const auto vertices = std::make_shared<const std::vector<Point3>>(mesh.vertices);
    KeyDivider divider(*moving, mesh, {*scene_.bodies[body].tolerance, options_.edgeFactor},
                       gltfElement(file_, "animations", animations_.front()));
    std::set<double> keys = {0, moving_->end};
    std::set<double> jumps = {0, moving_->end};
    for (const GltfCurve* curve : curvesOf(*shape)) {
      insertTimes(*curve, keys);
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
        if (auto done = divider.divide({times.back(), *key}, times); !done) {
          return done.error();
        }
      }
      runs.push_back(
          std::make_unique<ShapeRun>(moving, vertices, std::move(times), mirrored_[body]));
    }
    return runs;
  }

  void addHalfTurns() {
    std::set<const GltfCurve*> curves;
    for (const auto& shape : shapes_) curves.merge(curvesOf(*shape));
    for (const GltfNode& node : order_) {
      const GltfCurve* rotations = moving_->node(node.index).rotations;
      if (!curves.contains(rotations)) continue;
      const std::string& name = model_.nodes[static_cast<std::size_t>(node.index)].name;
      for (model::HalfTurn turn : rotations->halfTurns()) {
        turn.between += name.empty() ? fmt::format(" of node {}", node.index)
                                     : fmt::format(" of node '{}'", asName(name));
        scene_.halfTurns.push_back(std::move(turn));
      }
    }
    if (auto notice = model::noticeOfHalfTurns(scene_.halfTurns); !notice.empty()) {
      scene_.notices.push_back(std::move(notice));
    }
  }

  /// A shape that deforms by joints is where these are, but visible as its node is.
  bool isHidden(const GltfShape& shape, double begin, double end) const {
    const auto hiddenAt = [&](double time, Side side) {
      if (!moving_->isVisible(shape.node, time, side)) return true;
      return shape.joints.empty() && moving_->world(shape.node, time, side).linear().isZero(0);
    };
    return hiddenAt(begin, Side::Behind) && hiddenAt(begin / 2 + end / 2, Side::Behind) &&
           hiddenAt(end, Side::Before);
  }

  const InputFile& file_;
  const tinygltf::Model& model_;
  const GltfAnimationOptions& options_;
  std::vector<int> animations_;
  std::size_t hiddenInstances_ = 0;
  GltfUse used_;
  std::vector<GltfNode> order_;
  std::shared_ptr<const GltfHierarchy> moving_;
  std::vector<std::shared_ptr<const GltfShape>> shapes_;
  std::vector<bool> mirrored_;
  std::set<std::string> names_;
  GltfMaterialNames materials_{model_};
  AnimatedScene scene_;
};

}  // namespace

std::vector<platform::FileFormat> animatedGltfFormats() {
  return {{"animated glTF",
           {".gltf", ".glb"},
           {"triangles", "bodies", "names of bodies", "vertex attributes", "materials", "units"},
           true}};
}

Result<AnimatedScene> readGltfAnimation(const InputFile& file,
                                        const GltfAnimationOptions& options) {
  auto loaded = loadGltfModel(file);
  if (!loaded) return loaded.error();
  auto scene = AnimationReader(file, loaded->model, options).read();
  if (scene) scene->otherFiles = std::move(loaded->bufferFiles);
  return scene;
}

}  // namespace t4d::formats
