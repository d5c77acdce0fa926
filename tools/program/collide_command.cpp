#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/output_file.h"
#include "t4d/formats/triangle_mesh_formats.h"
#include "t4d/measure/collide.h"
#include "t4d/measure/collision_verdict.h"
#include "t4d/measure/overlap.h"
#include "t4d/measure/triangle_tree.h"
#include "t4d/measure/winding_number.h"
#include "t4d/slice/light_slice.h"
#include "t4d/slice/slice.h"
#include "tools/program/collide_page.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_bodies.h"
#include "tools/program/option_checks.h"
#include "tools/program/or_null.h"
#include "tools/program/progress_bar.h"

namespace t4d::tools {
namespace {

using formats::Metadata;
using measure::ClearanceVerdict;
using measure::Collision;
using measure::CollisionVerdict;
using measure::Contact;
using measure::Verdict;
using model::Point3;
using nlohmann::ordered_json;

struct CollideArguments {
  std::vector<std::string> inputs;
  InputOptions only;
  std::optional<double> clearance;
  bool failOnContact = false;
  bool ignoreUnits = false;
  std::string output;
  std::string html;
  bool json = false;
};

struct BodyPair {
  model::Body a;
  model::Body b;
  std::array<bool, 2> followPoses;
  Collision collision;
  CollisionVerdict verdict;
  std::optional<ClearanceVerdict> clearance;  // on --clearance

  bool keepsClearance() const {
    return !clearance || clearance->answer == ClearanceVerdict::Answer::Kept;
  }
};

/// The units of the first file count; differences are an error unless they are to be ignored.
Result<void> checkUnits(const InputBodies& a, const InputBodies& b) {
  const Metadata& ofA = a.reader.metadata();
  const Metadata& ofB = b.reader.metadata();
  const auto check = [&](const char* what, const std::string& p, const std::string& q,
                         const char* convert) -> Result<void> {
    if (p == q) return {};
    const auto named = [](const std::string& unit) {
      return unit.empty() ? std::string("not stated") : "'" + unit + "'";
    };
    return invalid(fmt::format("{} is {}, but that of {} is {}; convert one (t4d transform {}), or "
                               "take the numbers as they are with --ignore-units",
                               what, named(q), a.reader.name(), named(p), convert),
                   b.reader.name());
  };
  if (auto done = check("the unit of length", ofA.lengthUnit, ofB.lengthUnit,
                        "--scale FACTOR --length-unit NAME");
      !done) {
    return done;
  }
  if (auto done = check("the unit of time", ofA.timeUnit, ofB.timeUnit,
                        "--time-scale FACTOR --time-unit NAME");
      !done) {
    return done;
  }
  return check("the axis that points up", ofA.up, ofB.up, "--rotate 1 0 0 90 --up AXIS");
}

std::string_view nameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::Hit:
      return "hit";
    case Verdict::Touch:
      return "touch";
    case Verdict::Clear:
      return "clear";
    case Verdict::WithinTolerance:
      return "within-tolerance";
  }
  return "";
}

ordered_json jsonOf(const Point3& point) { return {point.x(), point.y(), point.z()}; }

ordered_json jsonOf(const std::optional<measure::CellNumber>& cell) {
  if (!cell) return {};
  return {{"slab", cell->slab}, {"cell", cell->cell}};
}

/// The smallest steps that a verdict asks for, as `--rv-min`.
std::optional<double> decidingRatio(const BodyPair& pair) {
  const auto& clearance = pair.clearance ? pair.clearance->minVolumeRatio : std::nullopt;
  return std::max(pair.verdict.minVolumeRatio, clearance);
}

ordered_json jsonOf(const BodyPair& pair) {
  const Collision& collision = pair.collision;
  ordered_json value = {{"a", pair.a.name},
                        {"b", pair.b.name},
                        {"common", nullptr},
                        {"contact", collision.contact()},
                        {"verdict", nameOf(pair.verdict.verdict)},
                        {"first_contact", nullptr},
                        {"intervals", ordered_json::array()}};
  if (collision.common) value["common"] = {collision.common->begin, collision.common->end};
  for (const measure::ContactInterval& interval : collision.intervals) {
    value["intervals"].push_back({{"begin", interval.begin},
                                  {"end", interval.end},
                                  {"overlaps", interval.overlaps},
                                  {"deepest_time", interval.deepestTime},
                                  {"overlap_volume", interval.overlapVolume},
                                  {"overlap_volume_error", interval.volumeError}});
  }
  std::optional<double> distance;
  std::optional<double> bound;
  std::optional<double> time;
  ordered_json points;
  if (collision.contact()) {
    const Contact& first = collision.intervals.front().first;
    value["first_contact"] = {{"time", first.time},
                              {"point", jsonOf(first.point)},
                              {"cell_a", jsonOf(first.a)},
                              {"cell_b", jsonOf(first.b)}};
    distance = bound = 0;
    time = first.time;
    points = {jsonOf(first.point), jsonOf(first.point)};
  } else if (collision.clearance) {
    const measure::Clearance& nearest = *collision.clearance;
    distance = nearest.distance;
    bound = nearest.lowerBound;
    time = nearest.time;
    points = {jsonOf(nearest.pointA), jsonOf(nearest.pointB)};
  }
  value["min_clearance"] = orNull(distance);
  value["min_clearance_bound"] = orNull(bound);
  value["min_clearance_time"] = orNull(time);
  value["min_clearance_points"] = points;
  value["chord_bound"] = orNull(pair.verdict.chordBound);
  value["depth"] = pair.verdict.depth;
  value["clear_by"] = collision.common ? ordered_json(pair.verdict.clearBy) : ordered_json();
  value["rv_min"] = orNull(decidingRatio(pair));
  value["keeps_clearance"] = pair.clearance ? ordered_json(pair.keepsClearance()) : ordered_json();
  value["breaks_clearance"] =
      pair.clearance ? ordered_json(pair.clearance->answer == ClearanceVerdict::Answer::NotKept)
                     : ordered_json();
  return value;
}

std::string text(const Point3& point) {
  return fmt::format("({:.12g}, {:.12g}, {:.12g})", point.x(), point.y(), point.z());
}

bool overlaps(const Collision& collision) {
  return std::any_of(collision.intervals.begin(), collision.intervals.end(),
                     [](const measure::ContactInterval& interval) { return interval.overlaps; });
}

/// A positive number with some significant digits, or as many as keep it on its side of a limit,
/// rounded down or up but for the rounding of the product here.
std::string rounded(bool down, double number, int digits, double limit) {
  constexpr double kRounding = 1e-12;
  for (; digits < 16; ++digits) {
    const double unit = std::pow(10, std::floor(std::log10(number)) + 1 - digits);
    const double units = down ? std::floor(number / unit * (1 + kRounding))
                              : std::ceil(number / unit * (1 - kRounding));
    const std::string text = fmt::format("{:.{}g}", units * unit, digits);
    const double shown = std::stod(text);
    if (down ? shown >= limit : shown < limit) return text;
  }
  return fmt::format("{}", number);
}
std::string atLeast(double bound, int digits, double limit = 0) {
  return bound > 0 ? rounded(true, bound, digits, limit) : "0";
}
std::string atMost(double bound, int digits,
                   double limit = std::numeric_limits<double>::infinity()) {
  return bound > 0 ? rounded(false, bound, digits, limit) : "0";
}

std::string ratioText(double ratio) {
  constexpr double kDigits = 1e9;
  return fmt::format("--rv-min {}", std::ceil(ratio * kDigits) / kDigits);
}

/// What the meshes do where the verdict is open, by how much.
std::string howNear(const BodyPair& pair) {
  if (!pair.collision.contact()) {
    return fmt::format("come as near as {:.4g}", pair.collision.clearance->distance);
  }
  return pair.verdict.depth > 0 ? fmt::format("overlap by {:.4g}", pair.verdict.depth) : "touch";
}

/// What is certain, as a sentence.
std::string sentenceOf(const BodyPair& pair, const std::optional<double>& clearance) {
  const CollisionVerdict& verdict = pair.verdict;
  if (!pair.collision.common) return "clear: they never exist at the same time";
  std::string sentence;
  switch (verdict.verdict) {
    case Verdict::Hit:
      sentence = fmt::format("hit: they overlap, {} deep at least", atLeast(verdict.depth, 4));
      break;
    case Verdict::Touch:
      sentence = overlaps(pair.collision)
                     ? "touch: they overlap by no more than the rounding of coordinates"
                     : "touch: they touch and never overlap";
      break;
    case Verdict::Clear:
      sentence = fmt::format(
          "clear by at least {}",
          atLeast(verdict.clearBy, 6, clearance && pair.keepsClearance() ? *clearance : 0));
      break;
    case Verdict::WithinTolerance:
      sentence = fmt::format("cannot be decided with these steps: the meshes {}", howNear(pair));
      break;
  }
  if (!verdict.chordsA && !verdict.chordsB) {
    return sentence +
           "; for the meshes as they are, since nothing is known of the motion between "
           "their layers";
  }
  if (const double bound = verdict.knownBound(); bound > 0) {
    sentence += verdict.chordBound
                    ? fmt::format("; the meshes are within {:.4g} of the motion", bound)
                    : fmt::format("; the mesh of {} is within {:.4g} of the motion",
                                  verdict.chordsA ? pair.a.name : pair.b.name, bound);
  }
  if (!verdict.chordBound) {
    sentence += fmt::format(
        "; {} counts as it is, since nothing is known of its motion between "
        "its layers",
        verdict.chordsA ? pair.b.name : pair.a.name);
  }
  if (verdict.minVolumeRatio) {
    sentence += fmt::format("; sweep with {} to decide it", ratioText(*verdict.minVolumeRatio));
  } else if (verdict.verdict == Verdict::WithinTolerance) {
    sentence += "; no finer sweep decides it: change the motion so that they overlap or stay apart";
  }
  return sentence;
}

/// What is certain of the clearance.
std::string clearanceSentence(const ClearanceVerdict& verdict, double clearance) {
  using Answer = ClearanceVerdict::Answer;
  std::string sentence = fmt::format("the clearance of {} is ", clearance);
  switch (verdict.answer) {
    case Answer::Kept:
      return sentence + "kept";
    case Answer::NotKept:
      sentence += "not kept";
      if (verdict.most > 0) {
        sentence +=
            fmt::format(": they come within {} of each other", atMost(verdict.most, 6, clearance));
      }
      return sentence;
    case Answer::Unknown:
      break;
  }
  sentence += fmt::format("not kept for certain: they come within {} to {} of each other",
                          atLeast(verdict.least, 6), atMost(verdict.most, 6));
  if (verdict.minVolumeRatio) {
    return sentence +
           fmt::format("; sweep with {} to decide it", ratioText(*verdict.minVolumeRatio));
  }
  return sentence + "; no finer sweep is known to decide it";
}

void printText(const BodyPair& pair, const CollideArguments& options) {
  const Collision& collision = pair.collision;
  print("{} and {}\n", pair.a.name, pair.b.name);
  print("  {}\n", sentenceOf(pair, options.clearance));
  if (collision.contact()) {
    const Contact& first = collision.intervals.front().first;
    print("  first contact at t = {}, {}\n", first.time, text(first.point));
    std::vector<std::vector<std::string>> rows = {
        {"  from", "to", "", "deepest at", "volume of the overlap"}};
    for (const measure::ContactInterval& interval : collision.intervals) {
      rows.push_back({fmt::format("  {}", interval.begin), fmt::format("{}", interval.end),
                      interval.overlaps ? "overlap" : "touch",
                      interval.overlaps ? fmt::format("{:.12g}", interval.deepestTime) : "",
                      interval.overlaps ? fmt::format("{:.6g}", interval.overlapVolume) : ""});
    }
    printTable(rows, "l");
  } else if (collision.clearance) {
    const measure::Clearance& nearest = *collision.clearance;
    print("  nearest at t = {:.12g}: {:.9g} apart, {} and {}\n", nearest.time, nearest.distance,
          text(nearest.pointA), text(nearest.pointB));
  }
  if (pair.clearance && collision.common) {
    print("  {}\n", clearanceSentence(*pair.clearance, *options.clearance));
  }
}

/// Two solids at the first contact of a pair or, without one, when they are nearest.
struct Shown {
  double time = 0;
  model::TriangleMesh a;
  model::TriangleMesh b;
  std::vector<bool> contactA;
  std::vector<bool> contactB;
};

/// The triangles that reach into the other solid, or within `near` of its surface or of the point.
std::vector<bool> contactOf(const model::TriangleMesh& mesh, const model::TriangleMesh& other,
                            const Point3& point, double near) {
  std::vector<bool> flags(mesh.triangles.size());
  if (other.triangles.empty() || mesh.triangles.empty()) return flags;
  const measure::TriangleTree own(mesh);
  const measure::TriangleTree tree(other);
  const measure::WindingNumber winding(other);
  const double reach = own.nearest(point).distance + near;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    bool found = own.distanceTo(i, point) <= reach;
    Point3 center = Point3::Zero();
    for (const std::uint32_t vertex : mesh.triangles[i]) center += mesh.vertices[vertex] / 3;
    found = found || tree.nearest(center, 2 * near).distance <= near || winding.at(center) > 0.75;
    flags[i] = found;
  }
  return flags;
}

Result<std::optional<Shown>> shownOf(const BodyPair& pair) {
  const Collision& collision = pair.collision;
  if (!collision.contact() && !collision.clearance) return std::optional<Shown>();
  Shown shown;
  shown.time = collision.contact() ? collision.intervals.front().begin : collision.clearance->time;
  auto a = slice::sliceAtTime(*pair.a.source, shown.time);
  if (!a) return pass(a.error());
  auto b = slice::sliceAtTime(*pair.b.source, shown.time);
  if (!b) return pass(b.error());
  shown.a = std::move(a->mesh);
  shown.b = std::move(b->mesh);
  shown.contactA.resize(shown.a.triangles.size());
  shown.contactB.resize(shown.b.triangles.size());
  if (collision.contact()) {
    constexpr double kNear = 1e-6;  // of the size: what is in contact up to rounding
    model::Bounds3 bounds = boundsOf(shown.a);
    bounds.add(boundsOf(shown.b));
    const double near = kNear * (bounds.max - bounds.min).norm();
    const Point3& point = collision.intervals.front().first.point;
    shown.contactA = contactOf(shown.a, shown.b, point, near);
    shown.contactB = contactOf(shown.b, shown.a, point, near);
  }
  return std::optional(std::move(shown));
}

formats::NamedMesh colouredMesh(const std::string& name, model::TriangleMesh mesh,
                                const std::vector<bool>& contact,
                                const std::array<float, 4>& colour) {
  constexpr std::array<float, 4> kRed = {0.6F, 0.01F, 0.02F, 1};
  formats::MeshColors colors{model::Domain::Cell, {}};
  for (const bool marked : contact) colors.colors.push_back(marked ? kRed : colour);
  formats::NamedMesh named{.name = name, .mesh = std::move(mesh)};
  named.colors = std::move(colors);
  return named;
}

/// The pair whose first contact comes first; without any contact, the one that comes nearest.
const BodyPair& pairToShow(const std::vector<BodyPair>& pairs) {
  const auto key = [](const BodyPair& pair) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    if (pair.collision.contact()) return std::pair(0, pair.collision.intervals.front().begin);
    const auto& clearance = pair.collision.clearance;
    return std::pair(1, clearance ? clearance->distance : kNever);
  };
  return *std::ranges::min_element(pairs, {}, key);
}

Result<std::vector<std::string>> writeContacts(const CollideArguments& options,
                                               const std::vector<BodyPair>& pairs,
                                               const Metadata& metadata) {
  const BodyPair& pair = pairToShow(pairs);
  auto shown = [&] {
    const ProgressBar bar("drawing");
    return shownOf(pair);
  }();
  if (!shown) return pass(shown.error());
  if (!*shown) {
    printNotices(
        {fmt::format("{} is not written: no two bodies exist at the same time", options.output)});
    return std::vector<std::string>();
  }
  std::vector<std::string> notices;
  formats::MeshWriteOptions how;
  how.time = (*shown)->time;
  if (formats::triangleMeshFormat(options.output)->placed) {
    how.placement = placementOf(metadata, notices);
  }
  printNotices(notices);
  const std::string nameB = pair.a.name == pair.b.name ? pair.b.name + " (2)" : pair.b.name;
  const std::vector<formats::NamedMesh> meshes = {
      colouredMesh(pair.a.name, std::move((*shown)->a), (*shown)->contactA,
                   {0.26F, 0.46F, 0.79F, 1}),
      colouredMesh(nameB, std::move((*shown)->b), (*shown)->contactB, {0.89F, 0.48F, 0.21F, 1})};
  const ProgressBar bar("writing " + options.output);
  return formats::writeTriangleMeshes(options.output, meshes, how);
}

/// A solid that stays as it is from time 0 to 1: three tetrahedra over each triangle.
model::Mesh standing(const model::TriangleMesh& solid) {
  const auto count = static_cast<std::uint32_t>(solid.vertices.size());
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->lowerCount = connectivity->upperCount = count;
  connectivity->vertexCount = 2 * count;
  model::Slab slab{0, 1, {}, nullptr, {}};
  for (const double time : {0.0, 1.0}) {
    for (const Point3& vertex : solid.vertices) {
      slab.vertices.emplace_back(vertex.x(), vertex.y(), vertex.z(), time);
    }
  }
  for (model::Triangle corners : solid.triangles) {
    // Sorted, so that prisms of neighbours fit; the order of corners keeps the orientation.
    const auto [p, q, r] = corners;
    const bool even = (p < q) == ((q < r) == (p < r));
    std::ranges::sort(corners);
    const auto [a, b, c] = corners;
    std::array<model::Cell, 3> cells = {model::Cell{a, b, c, c + count},
                                        model::Cell{a, b, b + count, c + count},
                                        model::Cell{a, a + count, b + count, c + count}};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (even == (i == 1)) std::swap(cells[i][0], cells[i][1]);
      connectivity->cells.push_back(cells[i]);
    }
  }
  slab.connectivity = connectivity;
  model::Mesh mesh;
  (void)mesh.put(slab);
  return mesh;
}

/// The distances of the two solids at these times; 0 during contact.
Result<std::vector<double>> clearancesAt(const BodyPair& pair, std::span<const double> times) {
  std::vector<double> clearances;
  const slice::LightSlicer slicerA(*pair.a.source);
  const slice::LightSlicer slicerB(*pair.b.source);
  for (const double time : times) {
    const auto meets = [&](const measure::ContactInterval& interval) {
      return interval.begin <= time && time <= interval.end;
    };
    if (std::ranges::any_of(pair.collision.intervals, meets)) {
      clearances.push_back(0);
      continue;
    }
    const auto a = slicerA.at(time);
    if (!a) return pass(a.error());
    const auto b = slicerB.at(time);
    if (!b) return pass(b.error());
    const auto found = measure::collide(standing(a->slice.mesh), standing(b->slice.mesh),
                                        {.overlapVolumes = false});
    if (!found) return pass(found.error());
    clearances.push_back(found->clearance ? found->clearance->distance : 0);
  }
  return clearances;
}

Result<void> writePage(const CollideArguments& options, const std::vector<BodyPair>& pairs,
                       const Metadata& metadata) {
  constexpr std::uint64_t kSamples = 65;
  CollideReport made;
  made.lengthUnit = metadata.lengthUnit;
  made.timeUnit = metadata.timeUnit;
  made.zUp = metadata.up == "z";
  for (const std::string& input : options.inputs) {
    made.title +=
        (made.title.empty() ? "" : " and ") + std::filesystem::path(input).filename().string();
  }
  ProgressBar bar("drawing", pairs.size(), "pairs");
  const model::Progress progress = bar.callback();
  for (const BodyPair& pair : pairs) {
    CollidePair one;
    one.a = pair.a.name;
    one.b = pair.b.name;
    one.verdict = sentenceOf(pair, options.clearance);
    if (pair.collision.common) {
      one.times = model::evenTimes(*pair.collision.common, kSamples);
      auto clearances = clearancesAt(pair, one.times);
      if (!clearances) return pass(clearances.error());
      one.clearance = std::move(*clearances);
    }
    if (pair.collision.contact()) {
      auto volumes = measure::overlapVolumes(*pair.a.source, *pair.b.source, one.times);
      if (!volumes) return pass(volumes.error());
      one.overlaps = std::move(*volumes);
    }
    auto shown = shownOf(pair);
    if (!shown) return pass(shown.error());
    if (*shown) {
      one.time = (*shown)->time;
      one.solidA = std::move((*shown)->a);
      one.solidB = std::move((*shown)->b);
      one.contactA = std::move((*shown)->contactA);
      one.contactB = std::move((*shown)->contactB);
    }
    made.pairs.push_back(std::move(one));
    progress(static_cast<double>(made.pairs.size()) / static_cast<double>(pairs.size()));
  }
  auto file = formats::OutputFile::create(options.html);
  if (!file) return pass(file.error());
  const std::string text = collidePage(made);
  return file->write(text.data(), text.size()).and_then([&] { return file->commit(); });
}

/// Which bodies are tested: those of one file with those of the other, or all of one file.
std::vector<BodyPair> pairsOf(const std::vector<InputBodies>& inputs) {
  std::vector<BodyPair> pairs;
  const std::vector<model::Body>& first = inputs.front().bodies;
  const std::vector<model::Body>& last = inputs.back().bodies;
  const std::array follow = {followsPoses(inputs.front()), followsPoses(inputs.back())};
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = inputs.size() == 1 ? i + 1 : 0; j < last.size(); ++j) {
      pairs.push_back({first[i], last[j], follow, {}, {}, {}});
    }
  }
  return pairs;
}

int run(const CollideArguments& options) {
  const std::array outputs = {options.output, options.html};
  for (const std::string& output : outputs) {
    if (output.empty()) continue;
    if (const auto misuse = misuseOfOutput(output, options.inputs)) return wrongUsage(*misuse);
  }
  if (const auto misuse = misuseOfOutputs(std::array{options.output, options.html})) {
    return wrongUsage(*misuse);
  }
  if (auto writable = checkWritable(outputs); !writable) return report(writable.error());
  std::vector<InputBodies> inputs;
  for (const std::string& path : options.inputs) {
    auto opened = openBodies(path, options.only);
    if (!opened) return report(opened.error());
    inputs.push_back(std::move(*opened));
  }
  if (inputs.size() == 2 && !options.ignoreUnits) {
    if (auto checked = checkUnits(inputs[0], inputs[1]); !checked) return report(checked.error());
  }
  std::vector<BodyPair> pairs = pairsOf(inputs);
  if (pairs.empty()) {
    return report(inInput(Error{ErrorCode::InvalidInput,
                                "has one body only, which cannot collide with itself; name a "
                                "second file",
                                {},
                                {}},
                          inputs.front()));
  }
  {
    ProgressBar bar("looking for contacts", pairs.size(), "pairs");
    for (BodyPair& pair : pairs) {
      auto collision = measure::collide(*pair.a.source, *pair.b.source, {}, bar.part(1));
      if (!collision) return report(inInput(collision.error(), inputs.front()));
      pair.collision = std::move(*collision);
      auto verdict =
          measure::verdictOn(pair.collision, *pair.a.source, *pair.b.source, pair.followPoses);
      if (!verdict) return report(inInput(verdict.error(), inputs.front()));
      pair.verdict = *verdict;
      if (options.clearance) {
        pair.clearance =
            measure::clearanceVerdict(pair.collision, pair.verdict, *options.clearance);
      }
    }
  }
  const Metadata& metadata = inputs.front().reader.metadata();
  std::vector<std::string> losses;
  if (!options.output.empty()) {
    auto done = writeContacts(options, pairs, metadata);
    if (!done) return report(done.error());
    losses = std::move(*done);
  }
  if (!options.html.empty()) {
    if (auto written = writePage(options, pairs, metadata); !written) {
      return report(written.error());
    }
  }
  if (options.json) {
    ordered_json value = {{"pairs", ordered_json::array()}};
    for (const BodyPair& pair : pairs) value["pairs"].push_back(jsonOf(pair));
    printJson(value);
  } else {
    for (const BodyPair& pair : pairs) printText(pair, options);
    for (const std::string& output : outputs) {
      std::error_code unknown;
      const std::uintmax_t size = std::filesystem::file_size(output, unknown);
      if (!unknown) print("{}: {}\n", output, sizeText(size));
    }
  }
  const int done = reportLosses(losses);
  const bool contact = std::ranges::any_of(pairs, [&](const BodyPair& pair) {
    return pair.collision.contact() || pair.verdict.verdict == Verdict::WithinTolerance ||
           !pair.keepsClearance();
  });
  return options.failOnContact && contact ? kFailed : done;
}

}  // namespace

void addCollide(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "collide", "Find when moving solids touch or overlap, or their smallest distance");
  auto options = std::make_shared<CollideArguments>();
  command
      ->add_option("FILE", options->inputs,
                   "One .t4d file with several bodies, or two to test against each other")
      ->required()
      ->expected(1, 2);
  command
      ->add_option("--clearance", options->clearance,
                   "Check that at least this distance is kept, in length units")
      ->check(numberFromZero());
  command->add_flag("--fail-on-contact", options->failOnContact,
                    "Exit with 1 if bodies meet, may meet or do not keep --clearance");
  command->add_flag("--ignore-units", options->ignoreUnits,
                    "Ignore differences in units and up axes");
  command
      ->add_option("-o,--output", options->output,
                   "Output file (.glb): both solids at the first contact, contacts in red")
      ->check(writableTriangleMesh());
  command
      ->add_option("--html", options->html,
                   "Write a page with clearance and overlap over time, and pictures")
      ->check(someName());
  options->only.addTo(*command);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  t4d collide bolt.t4d nut.t4d --clearance 0.05 -o contacts.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
