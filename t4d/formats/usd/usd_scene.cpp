#include "t4d/formats/usd/usd_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "t4d/formats/t4d/names.h"
#include "t4d/formats/text/text_scanner.h"
#include "t4d/model/amount_text.h"
#include "t4d/model/units.h"

namespace t4d::formats {
namespace {

using Eigen::Affine3d;

constexpr double kUsdMetresPerUnit = 0.01;  // where a stage does not say
constexpr double kUsdTimeCodesPerSecond = 24;

bool isInvisible(std::string_view value) { return usdUnquoted(value) == "invisible"; }

/// A token holds until the next sample, and before the first one.
bool isInvisible(const UsdProperty& visibility, double timeCode) {
  const auto& samples = visibility.samples;
  if (samples.empty()) return visibility.value && isInvisible(*visibility.value);
  auto behind = std::ranges::upper_bound(samples, timeCode, {}, &UsdSample::timeCode);
  if (behind != samples.begin()) --behind;
  return isInvisible(behind->value);
}

bool isHiddenAt(const UsdPlacedMesh& mesh, double timeCode) {
  return std::ranges::any_of(mesh.visibility, [&](const UsdProperty* visibility) {
    return isInvisible(*visibility, timeCode);
  });
}

/// What composes a stage of several layers, or moves it.
bool isArc(std::string_view field) {
  constexpr std::string_view kArcs[] = {"references", "payload",     "inherits", "specializes",
                                        "variants",   "variantSets", "clips"};
  return std::ranges::find(kArcs, field) != std::end(kArcs);
}

bool isEmptyList(std::string_view value) { return value == "None" || value == "[]"; }

class SceneReader {
 public:
  explicit SceneReader(UsdScene& scene) : scene_(scene), document_(*scene.document) {}

  Result<void> read() {
    if (auto done = readStage(); !done) return done;
    for (const UsdPrim& prim : scene_.layer->prims) {
      if (auto done = visit(prim, {}); !done) return done;
    }
    if (auto done = readTimes(); !done) return done;
    nameMeshes();
    if (hidden_ > 0) {
      scene_.notices.push_back(fmt::format("left out {} whose purpose is guide or proxy",
                                           model::counted(hidden_, "prim")));
    }
    addLosses();
    return {};
  }

 private:
  struct Above {
    std::vector<UsdXformOp> ops = {};
    std::vector<const UsdProperty*> visibility = {};
  };

  Result<double> stageNumber(std::string_view field, double fallback) {
    const auto value = scene_.layer->field(field);
    if (!value) return fallback;
    const auto numbers = usdNumbers(document_, *value, 1, UsdShapeOf::One, "double");
    if (!numbers) return numbers.error();
    const bool isRate = field != "startTimeCode" && field != "endTimeCode";
    if (!std::isfinite((*numbers)[0]) || (isRate && !((*numbers)[0] > 0))) {
      return invalid(fmt::format("{} is {}, expected a {} number", field, (*numbers)[0],
                                 isRate ? "positive" : "finite"),
                     document_.where(*value));
    }
    return (*numbers)[0];
  }

  Result<void> readStage() {
    const UsdLayer& layer = *scene_.layer;
    if (const auto others = layer.field("subLayers"); others && !isEmptyList(*others)) {
      return refuse("the stage", "subLayers", *others);
    }
    const auto perFrame = stageNumber("framesPerSecond", kUsdTimeCodesPerSecond);
    if (!perFrame) return perFrame.error();
    const auto perSecond = stageNumber("timeCodesPerSecond", *perFrame);
    if (!perSecond) return perSecond.error();
    scene_.timeCodesPerSecond = *perSecond;
    const auto up = layer.field("upAxis");
    scene_.up = up && usdUnquoted(*up) == "Z" ? "z" : "y";
    const auto metres = stageNumber("metersPerUnit", kUsdMetresPerUnit);
    if (!metres) return metres.error();
    for (const char* unit : {"nm", "um", "mm", "cm", "dm", "m", "km", "in", "ft", "yd"}) {
      constexpr double kRounding = 1e-9;
      const double size = *model::metresPer(unit);
      if (std::abs(*metres - size) <= kRounding * size) scene_.lengthUnit = unit;
    }
    if (!scene_.lengthUnit.empty()) return {};
    scene_.lengthUnit = "m";
    stage_.ops.push_back(UsdXformOp::scaling(*metres));
    return {};
  }

  Error refuse(std::string_view who, std::string_view what, std::string_view at) const {
    return fail(ErrorCode::Unsupported,
                fmt::format("{} has {}, which are not read; `usdcat --flatten IN.usd -o OUT.usda` "
                            "writes one text with all that they say",
                            who, what),
                document_.where(at));
  }

  Result<void> checkPrim(const UsdPrim& prim) const {
    const std::string who = fmt::format("prim {}", inQuotes(prim.name));
    for (const auto& [key, value] : prim.metadata) {
      if (isArc(key) && !isEmptyList(value)) return refuse(who, key, value);
    }
    if (!prim.variantSet.empty()) return refuse(who, "variants", prim.variantSet);
    const auto skeleton = std::ranges::find_if(prim.properties, [](const UsdProperty& property) {
      return property.name == "skel:skeleton" || property.name == "primvars:skel:jointIndices" ||
             property.name == "skel:blendShapes";
    });
    if (skeleton != prim.properties.end()) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("{} is moved by a skeleton or blend shapes; only time samples of "
                              "points and xformOps are read: bake them",
                              who),
                  document_.where(skeleton->name));
    }
    if (prim.type == "PointInstancer") {
      return fail(ErrorCode::Unsupported,
                  fmt::format("{} is a PointInstancer, which is not read; make its instances "
                              "meshes of their own",
                              who),
                  document_.where(prim.name));
    }
    return {};
  }

  Result<void> visit(const UsdPrim& prim, const Above& above) {
    if (prim.specifier == "class" || prim.field("active") == "false") return {};
    if (auto good = checkPrim(prim); !good) return good;
    if (prim.specifier != "def") return {};  // what it adds to is not in this text
    const UsdProperty* purpose = prim.property("purpose");
    if (purpose != nullptr && purpose->value) {
      const std::string word = usdUnquoted(*purpose->value);
      if (word == "guide" || word == "proxy") {
        ++hidden_;
        return {};
      }
    }
    const auto xform = UsdXform::read(document_, prim, scene_.timeCodesPerSecond);
    if (!xform) return xform.error();
    Above here = xform->resets || above.ops.empty() ? stage_ : Above{above.ops};
    here.visibility = above.visibility;
    here.ops.insert(here.ops.end(), xform->ops.begin(), xform->ops.end());
    if (const UsdProperty* visibility = prim.property("visibility")) {
      here.visibility.push_back(visibility);
    }
    if (prim.type == "Mesh") {
      addMesh(prim, here);
    } else {
      count(prim.type);
    }
    for (const UsdPrim& child : prim.children) {
      if (auto done = visit(child, here); !done) return done;
    }
    return {};
  }

  void addMesh(const UsdPrim& prim, const Above& here) {
    const auto shown = prim.field("displayName");
    UsdPlacedMesh mesh{&prim, asName(shown ? usdUnquoted(*shown) : std::string(prim.name)),
                       here.ops, here.visibility};
    scene_.meshes.push_back(std::move(mesh));
    const UsdProperty* scheme = prim.property("subdivisionScheme");
    subdivided_ += scheme == nullptr || !scheme->value || usdUnquoted(*scheme->value) != "none";
    for (const UsdProperty& property : prim.properties) {
      constexpr std::string_view kPrimvars = "primvars:";
      if (property.name == "normals") look_.insert("normals");
      if (!property.name.starts_with(kPrimvars) || property.name.ends_with(":indices")) continue;
      look_.insert(asName(property.name.substr(kPrimvars.size())));
    }
  }

  /// Prims that hold what a solid has not.
  void count(std::string_view type) {
    constexpr std::string_view kHolders[] = {"",           "Xform",  "Scope",    "SkelRoot",
                                             "GeomSubset", "Shader", "NodeGraph"};
    if (std::ranges::find(kHolders, type) == std::end(kHolders)) ++others_[std::string(type)];
  }

  /// From the first sample to the last, unless the stage says what is played.
  Result<void> readTimes() {
    std::set<double> codes;
    const auto add = [&](const UsdProperty* property) {
      if (property == nullptr || property->samples.size() < 2) return;
      codes.insert(property->samples.front().timeCode);
      codes.insert(property->samples.back().timeCode);
    };
    for (const UsdPlacedMesh& mesh : scene_.meshes) {
      add(mesh.prim->property("points"));
      for (const UsdProperty* visibility : mesh.visibility) add(visibility);
      for (const UsdXformOp& op : mesh.ops) {
        if (!op.moves()) continue;
        codes.insert(op.firstCode());
        codes.insert(op.lastCode());
      }
    }
    scene_.animated = !codes.empty();
    if (codes.empty()) codes.insert(0);
    const auto begin = stageNumber("startTimeCode", *codes.begin());
    if (!begin) return begin.error();
    const auto end = stageNumber("endTimeCode", *codes.rbegin());
    if (!end) return end.error();
    const bool says = *begin < *end;
    scene_.beginCode = says ? *begin : *codes.begin();
    scene_.played = {scene_.seconds(scene_.beginCode),
                     scene_.seconds(says ? *end : *codes.rbegin())};
    return {};
  }

  void nameMeshes() {
    std::map<std::string, int> wanted;  // how often
    for (UsdPlacedMesh& mesh : scene_.meshes) {
      const std::string name = mesh.name;
      while (!wanted.emplace(mesh.name, 1).second) {
        mesh.name = fmt::format("{} {}", name, ++wanted[name]);
      }
    }
  }

  void addLosses() {
    if (subdivided_ > 0) {
      scene_.losses.push_back(
          fmt::format("the smooth surface of {}: the control mesh is read",
                      model::counted(subdivided_, "subdivision mesh", "subdivision meshes")));
    }
    std::vector<std::string> left;
    for (const auto& [type, number] : others_) {
      left.push_back(fmt::format("{} {}", number, asName(type)));
    }
    if (!left.empty()) {
      scene_.losses.push_back(
          fmt::format("{}: only prims of the type Mesh are read", fmt::join(left, ", ")));
    }
    if (!look_.empty()) {
      scene_.losses.push_back(
          fmt::format("{}: only points and faces are read", fmt::join(look_, ", ")));
    }
  }

  UsdScene& scene_;
  const UsdDocument& document_;
  Above stage_;  // what is above all prims
  std::size_t hidden_ = 0;
  std::size_t subdivided_ = 0;
  std::map<std::string, std::size_t> others_;
  std::set<std::string> look_;
};

}  // namespace

Affine3d UsdPlacedMesh::world(double time) const {
  Affine3d made = Affine3d::Identity();
  for (const UsdXformOp& op : ops) made = made * op.at(time);
  return made;
}

bool UsdPlacedMesh::moves() const { return std::ranges::any_of(ops, &UsdXformOp::moves); }

bool UsdScene::isHidden(const UsdPlacedMesh& mesh) const { return isHiddenAt(mesh, beginCode); }

std::vector<model::TimeSpan> UsdScene::visibleTimes(const UsdPlacedMesh& mesh) const {
  std::set<double> codes = {beginCode};
  for (const UsdProperty* property : mesh.visibility) {
    for (const UsdSample& sample : property->samples) codes.insert(sample.timeCode);
  }
  std::vector<model::TimeSpan> spans;
  for (auto code = codes.begin(); code != codes.end(); ++code) {
    const double begin = std::max(seconds(*code), played.begin);
    const double end = std::next(code) == codes.end()
                           ? played.end
                           : std::min(seconds(*std::next(code)), played.end);
    if (isHiddenAt(mesh, *code) || !(begin < end)) continue;
    if (!spans.empty() && spans.back().end == begin) {
      spans.back().end = end;
    } else {
      spans.push_back({begin, end});
    }
  }
  return spans;
}

Result<UsdScene> readUsdScene(InputFile file) {
  auto document = openUsd(std::move(file));
  if (!document) return document.error();
  UsdScene scene;
  scene.document = std::make_shared<const UsdDocument>(std::move(*document));
  auto layer = readUsdLayer(*scene.document);
  if (!layer) return layer.error();
  scene.layer = std::make_shared<const UsdLayer>(std::move(*layer));
  if (auto done = SceneReader(scene).read(); !done) return done.error();
  if (scene.meshes.empty()) {
    return invalid("holds no Mesh prim", scene.document->file->path.string());
  }
  return scene;
}

}  // namespace t4d::formats
