#include "t4d/formats/usd/usd_animation.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "t4d/formats/animation/shape_run.h"
#include "t4d/formats/file_extension.h"
#include "t4d/formats/usd/usd_shape.h"
#include "t4d/model/amount_text.h"

namespace t4d::formats {
namespace {

using model::Point3;

class UsdAnimationReader {
 public:
  UsdAnimationReader(const UsdScene& scene, const GltfAnimationOptions& options)
      : scene_(scene), options_(options), file_(scene.document->file->path.string()) {}

  Result<AnimatedScene> read() {
    if (!scene_.animated || !(scene_.played.begin < scene_.played.end)) {
      return invalid("has no animation: nothing has time samples at two times", file_,
                     Remedy::GiveMotion);
    }
    made_.notices = scene_.notices;
    made_.losses = scene_.losses;
    made_.lengthUnit = scene_.lengthUnit;
    made_.up = scene_.up;
    std::size_t hidden = 0;
    for (const UsdPlacedMesh& placed : scene_.meshes) {
      spans_.push_back(scene_.visibleTimes(placed));
      hidden += spans_.back().empty();
      if (spans_.back().empty()) {
        spans_.pop_back();
        continue;
      }
      if (auto done = readShape(placed); !done) return done.error();
    }
    if (shapes_.empty()) return invalid("holds no mesh that is visible", file_);
    if (hidden > 0) {
      made_.notices.push_back(
          fmt::format("left out {}", model::counted(hidden, "mesh that is never visible",
                                                    "meshes that are never "
                                                    "visible")));
    }
    if (auto done = chooseTolerances(); !done) return done.error();
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      if (auto done = addRuns(i); !done) return done.error();
    }
    if (auto notice = model::noticeOfHalfTurns(made_.halfTurns); !notice.empty()) {
      made_.notices.push_back(std::move(notice));
    }
    return std::move(made_);
  }

 private:
  Result<void> readShape(const UsdPlacedMesh& placed) {
    LoadedMesh loaded;
    auto shape = UsdShape::read(scene_, placed, UsdShape::When::Played, loaded);
    if (!shape) return shape.error();
    for (const std::string& notice : loaded.notices) {
      made_.notices.push_back(fmt::format("body '{}': {}", placed.name, notice));
    }
    const auto mirrors = mirrored(placed);
    if (!mirrors) return mirrors.error();
    mirrored_.push_back(*mirrors);
    if (*mirrors) {
      for (model::Triangle& triangle : loaded.mesh.triangles) std::swap(triangle[1], triangle[2]);
      if (!(*shape)->deforms()) {
        for (Point3& p : loaded.mesh.vertices) p.x() = -p.x();
      }
    }
    for (const UsdXformOp& op : placed.ops) {
      for (model::HalfTurn turn : op.halfTurns()) {
        turn.between += fmt::format(" of '{}'", placed.name);
        made_.halfTurns.push_back(std::move(turn));
      }
    }
    made_.bodies.push_back({placed.name, std::move(loaded.mesh), {}});
    shapes_.push_back(std::move(*shape));
    return {};
  }

  /// Whether its transform mirrors. Fails where it changes from one to the other, or has no size.
  Result<bool> mirrored(const UsdPlacedMesh& placed) const {
    std::set<double> times = {scene_.played.begin, scene_.played.end};
    for (const UsdXformOp& op : placed.ops) times.insert(op.times().begin(), op.times().end());
    const double first = placed.world(*times.begin()).linear().determinant();
    for (const double time : times) {
      const double factor = placed.world(time).linear().determinant();
      if (factor * first > 0 && std::isfinite(factor * first)) continue;
      return invalid(fmt::format("the transform of Mesh '{}' shrinks to nothing, or turns inside "
                                 "out, by time {} s",
                                 placed.name, time),
                     scene_.document->where(placed.prim->name));
    }
    return first < 0;
  }

  Result<void> chooseTolerances() {
    std::vector<double> extents;
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      const std::size_t count = made_.bodies[i].mesh.vertices.size();
      extents.push_back(largestExtent(*shapes_[i], count, scene_.played));
    }
    const auto tolerances = tolerancesOf(options_.tolerance, extents, file_);
    if (!tolerances) return tolerances.error();
    for (std::size_t i = 0; i < shapes_.size(); ++i) made_.bodies[i].tolerance = (*tolerances)[i];
    return {};
  }

  Result<void> addRuns(std::size_t i) {
    AnimatedBody& body = made_.bodies[i];
    const std::shared_ptr<const UsdShape>& shape = shapes_[i];
    const auto base = std::make_shared<const std::vector<Point3>>(body.mesh.vertices);
    const std::vector<double> keys = shape->times();
    KeyDivider divider(*shape, body.mesh, {*body.tolerance, options_.edgeFactor},
                       placeIn(file_, fmt::format("body '{}'", body.name)));
    for (const model::TimeSpan& span : spans_[i]) {
      std::vector<double> times = {span.begin};
      const auto add = [&](double key) {
        return key > times.back() ? divider.divide({times.back(), key}, times) : Result<void>();
      };
      for (const double key : keys) {
        if (key >= span.end) break;
        if (auto done = add(key); !done) return done;
      }
      if (auto done = add(span.end); !done) return done;
      body.runs.push_back(std::make_unique<ShapeRun>(shape, base, std::move(times), mirrored_[i]));
    }
    return {};
  }

  const UsdScene& scene_;
  const GltfAnimationOptions& options_;
  std::string file_;
  std::vector<std::shared_ptr<const UsdShape>> shapes_;
  std::vector<std::vector<model::TimeSpan>> spans_;  // in which each is visible
  std::vector<bool> mirrored_;
  AnimatedScene made_;
};

}  // namespace

std::vector<system::FileFormat> animatedUsdFormats() {
  return {{"animated USD",
           {".usda", ".usdz"},
           {"triangles", "bodies", "names of bodies", "attributes", "units"},
           true}};
}

bool isAnimatedUsd(const std::filesystem::path& path) {
  const std::string extension = lowerCaseExtension(path);
  return isOneOf(animatedUsdFormats(), path) || extension == ".usd" || extension == ".usdc";
}

Result<AnimatedScene> readUsdAnimation(InputFile file, const GltfAnimationOptions& options) {
  const auto scene = readUsdScene(std::move(file));
  if (!scene) return scene.error();
  return UsdAnimationReader(*scene, options).read();
}

}  // namespace t4d::formats
