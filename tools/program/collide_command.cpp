#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "t4d/formats/output_file.h"
#include "t4d/formats/triangle_mesh_formats.h"
#include "t4d/measure/overlap.h"
#include "t4d/slice/light_slice.h"
#include "t4d/verbs/collide.h"
#include "tools/program/collide_page.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/console_observer.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
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
using verbs::CollidedPair;

struct CollideArguments {
  std::vector<std::string> inputs;
  InputOptions only;
  verbs::CollideOptions collide;
  bool failOnContact = false;
  std::string output;
  std::string html;
  bool json = false;
};

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
std::string howNear(const CollidedPair& pair) {
  if (!pair.collision.contact()) {
    return fmt::format("come as near as {:.4g}", pair.collision.clearance->distance);
  }
  return pair.verdict.depth > 0 ? fmt::format("overlap by {:.4g}", pair.verdict.depth) : "touch";
}

/// What is certain, as a sentence.
std::string sentenceOf(const CollidedPair& pair, const std::optional<double>& clearance) {
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

void printReport(const CollidedPair& pair, const CollideArguments& options) {
  const Collision& collision = pair.collision;
  print("{} and {}\n", pair.a.name, pair.b.name);
  print("  {}\n", sentenceOf(pair, options.collide.clearance));
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
    print("  {}\n", clearanceSentence(*pair.clearance, *options.collide.clearance));
  }
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
Result<std::vector<double>> clearancesAt(const CollidedPair& pair, std::span<const double> times) {
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

Result<void> writePage(const CollideArguments& options, const std::vector<CollidedPair>& pairs,
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
  for (const CollidedPair& pair : pairs) {
    CollidePair one;
    one.a = pair.a.name;
    one.b = pair.b.name;
    one.verdict = sentenceOf(pair, options.collide.clearance);
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
    auto shown = verbs::contactView(pair);
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

/// Why these options cannot be.
std::optional<std::string> misuseOf(const CollideArguments& options) {
  for (const std::string& output : {options.output, options.html}) {
    if (output.empty()) continue;
    if (auto misuse = misuseOfOutput(output, options.inputs)) return misuse;
  }
  return misuseOfOutputs(std::array{options.output, options.html});
}

int run(const CollideArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const std::array outputs = {options.output, options.html};
  if (auto writable = checkWritable(outputs); !writable) return report(writable.error());
  std::vector<verbs::Input> inputs;
  for (const std::string& path : options.inputs) {
    auto opened = verbs::openInput(path, options.only);
    if (!opened) return report(opened.error());
    inputs.push_back(std::move(*opened));
  }
  ConsoleObserver observer;
  const auto found = verbs::collide(inputs, options.collide, observer);
  if (!found) return report(found.error());
  const Metadata& metadata = inputs.front().metadata;
  std::vector<std::string> losses;
  if (!options.output.empty()) {
    auto done = verbs::writeContacts(*found, metadata, options.output, observer);
    if (!done) return report(done.error());
    losses = std::move(*done);
  }
  if (!options.html.empty()) {
    if (auto written = writePage(options, found->pairs, metadata); !written) {
      return report(written.error());
    }
  }
  if (options.json) {
    tools::printText(jsonOf(*found) + "\n");
  } else {
    for (const CollidedPair& pair : found->pairs) printReport(pair, options);
    for (const std::string& output : outputs) {
      std::error_code unknown;
      const std::uintmax_t size = std::filesystem::file_size(output, unknown);
      if (!unknown) print("{}: {}\n", output, sizeText(size));
    }
  }
  const int done = reportLosses(losses);
  return options.failOnContact && found->mayMeet() ? kFailed : done;
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
      ->add_option("--clearance", options->collide.clearance,
                   "Check that at least this distance is kept, in length units")
      ->check(numberFromZero());
  command->add_flag("--fail-on-contact", options->failOnContact,
                    "Exit with 1 if bodies meet, may meet or do not keep --clearance");
  command->add_flag("--ignore-units", options->collide.ignoreUnits,
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
