#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/t4d/sweep_parts.h"
#include "tools/t4d/weave_names.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

std::string fileName(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

void addRule(const mesh4d::StepRule& rule, ordered_json& parameters) {
  if (const auto* fixed = std::get_if<mesh4d::StepsPerSegment>(&rule)) {
    parameters["steps"] = fixed->steps;
  } else if (const auto* deviation = std::get_if<mesh4d::MaxDeviation>(&rule)) {
    parameters["max_deviation"] = deviation->length;
  } else {
    parameters["rv_min"] = std::get<mesh4d::MinVolumeRatio>(rule).ratio;
  }
}

ordered_json voxelParameters(const VoxelMethod& how) {
  ordered_json parameters;
  parameters["voxel_size"] = how.voxelSize;
  if (how.times.count) parameters["frames"] = *how.times.count;
  if (how.times.step) parameters["frame_time"] = *how.times.step;
  parameters["mask"] = how.mask;
  if (how.mask) parameters["between"] = nameOfBetween(how.between);
  parameters["caps"] = nameOfCaps(how.caps);
  return parameters;
}

void addHow(const MotionSweep& what, ordered_json& parameters) { addRule(what.steps, parameters); }

void addHow(const DeformationSweep& what, ordered_json& parameters) {
  if (const auto& between = what.times.between) {
    parameters["times"] = fmt::format("{}:{}", between->begin, between->end);
  }
  if (what.times.step) parameters["frame_time"] = *what.times.step;
}

void addHow(const AnimationSweep& what, ordered_json& parameters) {
  if (what.tolerance) parameters["tolerance"] = *what.tolerance;
  if (!what.animation.empty()) parameters["animation"] = what.animation;
  if (!what.scene.empty()) parameters["scene"] = what.scene;
}

void addHow(const MechanismSweep& what, ordered_json& parameters) {
  addRule(what.steps, parameters);
  if (what.ownSteps) parameters["own_steps"] = true;
  if (!what.geometry.empty()) parameters["geometry"] = what.geometry;
}

ordered_json meshParameters(const SweepOptions& options) {
  ordered_json parameters;
  std::visit([&](const auto& what) { addHow(what, parameters); }, options.what);
  if (options.components) parameters["bodies"] = "component";
  parameters["caps"] = options.caps == mesh4d::CapMethod::Cone ? "cone" : "tetgen";
  parameters["prism"] = options.prism == mesh4d::PrismSplit::Three ? 3 : 14;
  return parameters;
}

ordered_json sourceOf(const SweepOptions& options) {
  const bool mechanism = std::holds_alternative<MechanismSweep>(options.what);
  ordered_json source{{mechanism ? "mechanism" : "mesh", fileName(modelOf(options))}};
  const auto* deformation = std::get_if<DeformationSweep>(&options.what);
  if (deformation == nullptr) {
    const std::vector<std::string> files = namedFilesOf(options);
    if (files.size() > 1) source["motion"] = fileName(files.back());
  } else if (formats::isPointCache(deformation->files.back())) {
    source["cache"] = fileName(deformation->files.back());
  } else if (deformation->files.size() > 1) {
    source["last_mesh"] = fileName(deformation->files.back());
    source["meshes"] = deformation->files.size();
  }
  return source;
}

}  // namespace

std::string sweepDetails(const SweepOptions& options, const SweepInput& input) {
  const auto* moved = std::get_if<MotionSweep>(&options.what);
  ordered_json parameters;
  if (options.united) {
    const VoxelUnion& united = *options.united;
    parameters = voxelParameters({input.voxelSize, united.times, /*mask=*/false, {}, united.caps});
    parameters["union"] = true;
  } else {
    parameters = moved != nullptr && moved->voxels ? voxelParameters(*moved->voxels)
                                                   : meshParameters(options);
  }
  const formats::T4dWriteOptions& writing = options.output.writing;
  parameters["precision"] = writing.float32 ? "float32" : "float64";
  if (moved != nullptr && moved->bodies) {
    parameters["bodies"] = *moved->bodies == formats::BodiesBy::Group ? "group" : "object";
  }
  if (writing.step) parameters["grid"] = *writing.step;
  ordered_json details{{"source", sourceOf(options)}, {"parameters", parameters}};
  std::size_t values = 0;
  for (const formats::JointCourse& joint : input.joints) values += joint.values.size();
  constexpr std::size_t kMostValues = 20'000;  // more would be most of the file
  if (values > 0 && values <= kMostValues) {
    details["joints"] = ordered_json::parse(formats::jointsJson(input.joints));
  }
  if (!input.materials.empty() && !options.united) details["materials"] = input.materials;
  return details.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace t4d::tools
