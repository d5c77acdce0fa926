#include "tools/verbs/compare.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/t4d/url.h"
#include "model/converted_source.h"
#include "model/parallel.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "tools/verbs/input.h"
#include "tools/verbs/origin.h"

namespace t4d::verbs {
namespace {

/// A file's name without its folder.
std::string shownFileName(const std::string& path) {
  return std::filesystem::path(formats::shownName(path)).filename().string();
}

/// An open file, converted to the units of the other file if they differ.
struct Side {
  explicit Side(Input opened) : input(std::move(opened)), bodies(input.bodies) {}
  Side(const Side&) = delete;
  Side& operator=(const Side&) = delete;

  Input input;
  std::vector<std::unique_ptr<model::ConvertedSource>> converted;
  std::vector<model::Body> bodies;
  ComparedMesh mesh;
};

/// The conversion from `from`, the length or time unit of the file at `path`, to `to`, that of the
/// file it is compared with; the identity if there is nothing to convert. Adds notices of what is
/// converted or assumed.
Result<model::UnitConversion> conversionTo(
    const std::string& to, const std::string& otherPath, const std::string& from,
    const std::string& path, const char* what,
    std::optional<model::UnitConversion> (*convert)(std::string_view, std::string_view),
    std::vector<std::string>& notes) {
  if (from.empty() != to.empty()) {
    const bool stated = to.empty();
    notes.push_back(fmt::format("only {} states a {} unit, {}; {} is assumed to use it as well",
                                stated ? path : otherPath, what, stated ? from : to,
                                stated ? otherPath : path));
    return model::UnitConversion{};
  }
  const auto conversion = convert(from, to);
  if (!conversion) {
    return invalid(fmt::format("its {} unit is '{}' and that of {} is '{}'; they differ and at "
                               "least one of them is unknown, so neither can be converted",
                               what, from, otherPath, to),
                   path);
  }
  if (!conversion->isIdentity()) {
    notes.push_back(fmt::format("{}s of {} are converted from {} to {}, the unit of {}", what, path,
                                from, to, otherPath));
  }
  return *conversion;
}

/// Converts `b` to the units of `a`.
Result<void> convertUnits(const Side& a, Side& b, std::vector<std::string>& notes) {
  const std::string& pathOfA = a.input.name;
  const std::string& pathOfB = b.input.name;
  const formats::Metadata& ofA = a.input.metadata;
  const formats::Metadata& ofB = b.input.metadata;
  auto length = conversionTo(ofA.lengthUnit, pathOfA, ofB.lengthUnit, pathOfB, "length",
                             model::lengthConversion, notes);
  if (!length) return length.error();
  auto time = conversionTo(ofA.timeUnit, pathOfA, ofB.timeUnit, pathOfB, "time",
                           model::timeConversion, notes);
  if (!time) return time.error();
  if (originOf(ofA) != originOf(ofB)) {
    notes.push_back(
        fmt::format("the origins of {} and {} lie elsewhere in the original "
                    "coordinates; positions are compared as they are in the files",
                    pathOfA, pathOfB));
  }
  if (length->isIdentity() && time->isIdentity()) return {};
  for (model::Body& body : b.bodies) {
    b.converted.push_back(std::make_unique<model::ConvertedSource>(*body.source, *length, *time));
    body.source = b.converted.back().get();
  }
  return {};
}

/// Reads a file and measures it, into `side.mesh`. An invalid mesh is measured, too, with a notice.
Result<void> measureSide(Side& side, const ComparedFile& file, Observer& observer) {
  ComparedMesh& mesh = side.mesh;
  mesh = file.mesh;
  mesh.backend = side.input.metadata.backend;
  mesh.bytes = side.input.reader->fileBytes();
  if (mesh.name.empty()) {
    mesh.name = shownFileName(file.path);
    if (!mesh.backend.empty()) mesh.name += " (" + mesh.backend + ")";
  }
  const auto stage =
      observer.stage("measuring " + shownFileName(file.path), slabCountOf(side.bodies), "slabs");
  for (const model::Body& body : side.bodies) {
    auto report = measure::checkMesh(*body.source, {}, stage->part(body.source->slabCount()));
    if (!report) {
      Error error = report.error();
      if (error.where.empty()) error.where = side.input.name;
      return error;
    }
    mesh.vertices += report->vertices;
    mesh.tetrahedra += report->tetrahedra;
    mesh.hypervolume += report->hypervolume;
    if (!report->valid()) {
      observer.note(
          fmt::format("{}: body '{}' is not a closed, oriented 4D mesh; validating it says why",
                      side.input.name, body.name));
    }
  }
  return {};
}

/// Measures the shape of the cells, with the time scale of the other mesh or, without one, the mean
/// normal speed of this one.
Result<void> measureShapes(Side& side, std::optional<double> timeScale, Observer& observer) {
  CellShapes& shapes = side.mesh.shapes;
  const auto stage = observer.stage("measuring the cells of " + side.mesh.name);
  if (!timeScale) {
    const auto speed = measure::meanNormalSpeed(side.bodies, stage->callback());
    if (!speed) return inInput(speed.error(), side.input);
    timeScale = *speed > 0 ? *speed : 1;
  }
  const auto quality = measure::measureQuality(side.bodies, {.timeScale = *timeScale, .worst = 0},
                                               stage->callback());
  if (!quality) return inInput(quality.error(), side.input);
  shapes.timeScale = *timeScale;
  for (std::size_t k = 0; k < measure::kQualityMeasures.size(); ++k) {
    const std::string_view name = measure::kQualityMeasures[k].name;
    if (name != "radius_ratio" && name != "smallest_angle") continue;
    const measure::Distribution all = quality->all(k);
    const CellQuantiles quantiles{all.quantile(0.01), all.quantile(0.5), all.quantile(0.99)};
    (name == "radius_ratio" ? shapes.radiusRatio : shapes.smallestAngle) = quantiles;
  }
  return {};
}

/// The times to compare at. Without options, in the middle of steps: of a swept mesh, since the
/// volume of a woven one changes little between its frames.
std::vector<double> comparedTimes(const CompareOptions& options, const Side& a, const Side& b,
                                  const model::TimeSpan& span) {
  constexpr std::uint64_t kDefaultSlices = 9;
  if (!options.times.empty()) return options.times;
  if (options.slices) return model::evenTimes(span, *options.slices);
  const bool ofB = a.mesh.backend == "voxel4d" && b.mesh.backend != "voxel4d";
  return measure::timesAmidSteps(ofB ? b.bodies : a.bodies, span, kDefaultSlices);
}

/// If all times fall on layers of a mesh: what that misses, and a number of slices that would not.
std::optional<std::string> aliasing(const CompareOptions& options, const Side& a, const Side& b,
                                    const model::TimeSpan& span, const std::vector<double>& times) {
  std::vector<std::string> where;
  for (const auto& [side, letter] : {std::pair{&a, "a"}, std::pair{&b, "b"}}) {
    if (measure::timesOnLayers(side->bodies, times) < times.size()) continue;
    where.push_back(
        fmt::format("{} of {}", side->mesh.backend == "voxel4d" ? "frames" : "layers", letter));
  }
  if (where.empty()) return std::nullopt;
  std::string note = fmt::format("all comparison times are {}, so nothing between them is compared",
                                 fmt::join(where, " and "));
  if (!options.times.empty()) return note + "; choose other times";
  constexpr std::uint64_t kTries = 20;
  for (std::uint64_t n = times.size() + 1; n < times.size() + kTries; ++n) {
    const std::vector<double> others = model::evenTimes(span, n);
    if (2 * measure::timesOnLayers(a.bodies, others) > n) continue;
    if (2 * measure::timesOnLayers(b.bodies, others) > n) continue;
    return note + fmt::format("; try {} slices", n);
  }
  return note;
}

/// The solids at so many of the times, the first and the last among them.
Result<std::vector<SolidPair>> pairsToShow(const Side& a, const Side& b,
                                           const std::vector<double>& times, std::size_t most) {
  std::vector<SolidPair> pairs;
  const std::size_t count = std::min(most, times.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = count == 1 ? 0 : i * (times.size() - 1) / (count - 1);
    auto solidOfA = measure::solidAt(a.bodies, times[at]);
    if (!solidOfA) return solidOfA.error();
    auto solidOfB = measure::solidAt(b.bodies, times[at]);
    if (!solidOfB) return solidOfB.error();
    pairs.push_back({times[at], std::move(*solidOfA), std::move(*solidOfB)});
  }
  return pairs;
}

/// Opens and measures a file; `a` is the one that it is compared with, if there is one.
Result<std::unique_ptr<Side>> openSide(const ComparedFile& file, const Side* a,
                                       const CompareOptions& options,
                                       std::vector<std::string>& notes, Observer& observer) {
  auto opened = openInput(file.path, {.bodies = {}, .maxCells = options.maxCells});
  if (!opened) return opened.error();
  auto side = std::make_unique<Side>(std::move(*opened));
  if (a != nullptr) {
    if (auto done = convertUnits(*a, *side, notes); !done) return done.error();
  }
  if (auto done = measureSide(*side, file, observer); !done) return done.error();
  std::optional<double> timeScale;
  if (a != nullptr) timeScale = a->mesh.shapes.timeScale;
  if (auto done = measureShapes(*side, timeScale, observer); !done) return done.error();
  return side;
}

/// Compares the solids of some bodies at each time, one on each thread, which has two slabs and two
/// slices in memory.
Result<std::vector<ComparedSlice>> compareBodies(std::span<const model::Body> a,
                                                 std::span<const model::Body> b,
                                                 std::span<const double> times,
                                                 const model::Progress& progress) {
  const auto at = [&](std::size_t i) -> Result<ComparedSlice> {
    auto solidOfA = measure::solidAt(a, times[i]);
    if (!solidOfA) return solidOfA.error();
    auto solidOfB = measure::solidAt(b, times[i]);
    if (!solidOfB) return solidOfB.error();
    auto compared = measure::compareSolids(times[i], *solidOfA, *solidOfB);
    if (!compared) return compared.error();
    return ComparedSlice{*compared, surfaceAgreement(*solidOfA, *solidOfB)};
  };
  using Item = std::shared_ptr<const Result<ComparedSlice>>;
  std::vector<ComparedSlice> slices;
  Result<void> done;
  model::inOrder<Item>(
      times.size(),
      [&](std::size_t i) { return std::make_shared<const Result<ComparedSlice>>(at(i)); },
      [&](const Item& compared) {
        if (!*compared) {
          done = compared->error();
          return false;
        }
        slices.push_back(**compared);
        done = model::report(progress, slices.size(), times.size());
        return done.has_value();
      });
  if (!done) return done.error();
  return slices;
}

/// Compares the bodies of each name, those of a first.
Result<std::vector<ComparedBody>> compareEachBody(const Side& a, const Side& b,
                                                  std::span<const double> times,
                                                  Observer& observer) {
  std::vector<std::string> names;
  for (const Side* side : {&a, &b}) {
    for (const model::Body& body : side->bodies) {
      if (std::ranges::find(names, body.name) == names.end()) names.push_back(body.name);
    }
  }
  const auto ofName = [](const Side& side, const std::string& name) {
    std::vector<model::Body> bodies;
    std::ranges::copy_if(side.bodies, std::back_inserter(bodies),
                         [&](const model::Body& body) { return body.name == name; });
    return bodies;
  };
  const auto stage = observer.stage("comparing bodies", names.size() * times.size(), "slices");
  std::vector<ComparedBody> bodies;
  for (const std::string& name : names) {
    auto slices = compareBodies(ofName(a, name), ofName(b, name), times, stage->part(times.size()));
    if (!slices) return slices.error();
    bodies.push_back({name, std::move(*slices)});
  }
  return bodies;
}

/// Compares `b` with `a`, and adds to the report.
Result<void> compareSides(const Side& a, const Side& b, bool isLast, const CompareOptions& options,
                          std::vector<std::string> notes, CompareReport& report,
                          Observer& observer) {
  const auto unitOf = [&](std::string formats::Metadata::*unit) {
    const std::string& ofA = a.input.metadata.*unit;
    return ofA.empty() ? b.input.metadata.*unit : ofA;
  };
  report.lengthUnit = unitOf(&formats::Metadata::lengthUnit);
  report.timeUnit = unitOf(&formats::Metadata::timeUnit);

  std::vector<model::Body> all = a.bodies;
  all.insert(all.end(), b.bodies.begin(), b.bodies.end());
  const model::TimeSpan span = model::timeSpanOf(all);
  const std::vector<double> times = comparedTimes(options, a, b, span);
  for (const double time : times) {
    if (model::timeWithin(span, time)) continue;
    return invalid(fmt::format("nothing exists at time {}; the meshes last from {} to {}", time,
                               span.begin, span.end));
  }
  const auto note = aliasing(options, a, b, span, times);
  if (note && std::ranges::find(report.notes, *note) == report.notes.end()) notes.push_back(*note);
  observer.noteEach(notes);
  report.notes.insert(report.notes.end(), notes.begin(), notes.end());

  const auto stage = observer.stage("comparing", times.size(), "slices");
  auto slices = compareBodies(a.bodies, b.bodies, times, stage->callback());
  if (!slices) return slices.error();
  report.comparisons.push_back({a.mesh, b.mesh, std::move(*slices), options.volumeExpected});
  if (options.eachBody) {
    auto bodies = compareEachBody(a, b, times, observer);
    if (!bodies) return bodies.error();
    report.comparisons.back().bodies = std::move(*bodies);
  }
  if (!isLast || options.pairs == 0) return {};
  auto pairs = pairsToShow(a, b, times, options.pairs);
  if (!pairs) return pairs.error();
  report.pairs = std::move(*pairs);
  return {};
}

}  // namespace

Result<CompareReport> compare(const ComparedFile& a, std::span<const ComparedFile> others,
                              const CompareOptions& options, Observer& observer) {
  CompareReport report;
  const auto first = openSide(a, nullptr, options, report.notes, observer);
  if (!first) return first.error();
  report.zUp = (*first)->input.metadata.up == "z";
  for (const ComparedFile& other : others) {
    std::vector<std::string> notes;
    const auto side = openSide(other, first->get(), options, notes, observer);
    if (!side) return side.error();
    if (auto done = compareSides(**first, **side, &other == &others.back(), options,
                                 std::move(notes), report, observer);
        !done) {
      return done.error();
    }
  }
  return report;
}

}  // namespace t4d::verbs
