#include "tools/t4d/input.h"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/body_details.h"
#include "model/source_part.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/similar_words.h"

namespace t4d::tools {
namespace {

bool has(const Input& input, const std::string& body) {
  return std::ranges::find(input.bodies, body, &model::Body::name) != input.bodies.end();
}

Result<void> addBounds(const model::Source& source, model::Bounds3& bounds) {
  for (std::size_t i = 0; i < source.slabCount(); ++i) {
    if (const auto known = source.bounds(i)) {
      bounds.add(*known);
      continue;
    }
    const auto slab = source.slab(i);
    if (!slab) return slab.error();
    for (const model::Point4& vertex : (*slab)->vertices) bounds.add(vertex.head<3>());
  }
  return {};
}

/// Slabs that are written to a file of their own: where the next part begins, both store the layer
/// in the same way, as its positions.
class PartToWrite : public model::SourcePart {
 public:
  PartToWrite(const model::Source& whole, const model::PartRange& range)
      : SourcePart(whole, range.begin, range.end), goesOn_(range.end < whole.slabCount()) {}

  Result<std::shared_ptr<const model::Slab>> slab(std::size_t index) const override {
    auto slab = SourcePart::slab(index);
    if (!slab || !goesOn_ || index + 1 < slabCount() || !(*slab)->upperPose) return slab;
    auto without = std::make_shared<model::Slab>(**slab);
    without->upperPose = nullptr;
    return without;
  }

 private:
  bool goesOn_;
};

/// Whether the details of a file do not say that its sweep was of an animation; of a merged file,
/// whether none of those that it was made of do.
bool sweptFromMotion(const nlohmann::json& details) {
  if (!details.is_object()) return true;
  if (const auto merged = details.find("merged"); merged != details.end()) {
    return std::ranges::all_of(*merged, [](const nlohmann::json& file) {
      return !file.is_object() || !file.contains("details") || sweptFromMotion(file["details"]);
    });
  }
  const auto source = details.find("source");
  return source == details.end() || !source->is_object() || !source->contains("mesh") ||
         source->contains("motion");
}

}  // namespace

Result<Input> openInput(const std::string& path, const InputOptions& options) {
  auto opened = formats::T4dReader::open(path, formats::T4dOpen::Whole, {}, options.maxCells);
  if (!opened) return opened.error();
  auto reader = std::make_shared<formats::T4dReader>(std::move(*opened));
  Input input{reader->name(), reader->metadata(), {}, reader};
  const std::vector<formats::BodyInfo>& infos = input.metadata.bodies;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < infos.size(); ++i) {
    names.push_back(infos[i].name);
    if (options.bodies.empty() || std::ranges::count(options.bodies, names[i]) > 0) {
      input.bodies.push_back({names[i], &reader->body(i)});
    }
  }
  for (const std::string& wanted : options.bodies) {
    if (std::ranges::count(names, wanted) > 0) continue;
    return invalid(fmt::format("has no body '{}'{}; it has {}", wanted, didYouMean(wanted, names),
                               fmt::join(names, ", ")),
                   input.name);
  }
  return input;
}

std::uint64_t mostParts(const Input& input, bool ofEach) {
  std::optional<std::uint64_t> most;
  for (const model::Body& body : input.bodies) {
    const std::uint64_t slabs = body.source->slabCount();
    const std::uint64_t found = most.value_or(slabs);
    most = ofEach ? std::min(found, slabs) : std::max(found, slabs);
  }
  return most.value_or(0);
}

Result<Input> partOf(const Input& input, const model::Part& part, bool ofEach) {
  const std::uint64_t most = mostParts(input, ofEach);
  if (most < part.count) {
    return fail(ErrorCode::Options,
                fmt::format("has {} slab{}{}, too few for {} parts", most, most == 1 ? "" : "s",
                            input.bodies.size() > 1 ? " in a body" : "", part.count),
                input.name);
  }
  Input some = input;
  for (model::Body& body : some.bodies) {
    const model::PartRange range = part.of(body.source->slabCount());
    some.parts.push_back(std::make_shared<const PartToWrite>(*body.source, range));
    body.source = some.parts.back().get();
  }
  return some;
}

std::uint64_t slabCountOf(std::span<const model::Body> bodies) {
  std::uint64_t count = 0;
  for (const model::Body& body : bodies) count += body.source->slabCount();
  return count;
}

formats::Metadata metadataOf(const Input& input, std::string_view generator) {
  formats::Metadata metadata = input.metadata;
  metadata.generator = generator;
  std::erase_if(metadata.bodies,
                [&](const formats::BodyInfo& body) { return !has(input, body.name); });
  for (formats::BodyInfo& body : metadata.bodies) {
    if (!has(input, body.parent)) body.parent.clear();
  }
  return metadata;
}

Result<std::uint64_t> finishEdited(formats::T4dWriter& writer, const Input& input) {
  if (input.reader) {
    if (auto kept = writer.keep(input.reader->optionalChunks()); !kept) return kept.error();
  }
  return writer.finish();
}

Error inInput(Error error, const Input& input) {
  if (error.where.empty()) error.where = input.name;
  return error;
}

Result<void> checkSameUnits(const Input& a, const Input& b) {
  const auto named = [](const std::string& unit) {
    return unit.empty() ? std::string("not stated") : "'" + unit + "'";
  };
  for (const auto& [what, ofA, ofB] :
       {std::tuple("the unit of length", a.metadata.lengthUnit, b.metadata.lengthUnit),
        std::tuple("the unit of time", a.metadata.timeUnit, b.metadata.timeUnit),
        std::tuple("the axis that points up", a.metadata.up, b.metadata.up)}) {
    if (ofA == ofB) continue;
    return invalid(
        fmt::format("{} is {}, but that of {} is {}", what, named(ofB), a.name, named(ofA)), b.name,
        Remedy::Units);
  }
  return {};
}

measure::MotionBetweenLayers motionOf(const Input& input, const std::string& body) {
  measure::MotionBetweenLayers motion;
  motion.isKnown =
      sweptFromMotion(nlohmann::json::parse(input.metadata.detailsJson, nullptr, false));
  for (const formats::BodyInfo& info : input.metadata.bodies) {
    if (info.name == body) motion.bound = formats::chordBoundOf(info);
  }
  return motion;
}

Result<model::Bounds3> boundsOf(const Input& input) {
  model::Bounds3 bounds;
  if (!input.reader) {
    for (const model::Body& body : input.bodies) {
      if (auto added = addBounds(*body.source, bounds); !added) return added.error();
    }
    return bounds;
  }
  const std::vector<formats::BodyInfo>& infos = input.reader->metadata().bodies;
  for (std::size_t i = 0; i < infos.size(); ++i) {
    if (has(input, infos[i].name)) bounds.add(input.reader->summary(i).bounds);
  }
  return bounds;
}

void InputOptions::addTo(CLI::App& command) {
  command.add_option("--body", bodies, "Use only this body; repeatable (default: all)")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->check(someName());
  addMaxCellsOption(command, maxCells);
}

void addMaxCellsOption(CLI::App& command, std::optional<std::uint64_t>& maxCells) {
  command
      .add_option("--max-cells", maxCells,
                  "Maximum number of cells to accept (default: see docs/limits.md)")
      ->type_name("N");
}

}  // namespace t4d::tools
