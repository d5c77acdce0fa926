#include "tools/t4d/diff.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/manifest.h"
#include "measure/mesh_digest.h"
#include "model/progress.h"
#include "t4d/check.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

using formats::T4dReader;

/// False also for what is not a file here, such as a URL, and for files in parts, of which only
/// the manifests would be compared.
bool haveTheSameBytes(const std::filesystem::path& a, const std::filesystem::path& b) {
  if (formats::isManifest(a) || formats::isManifest(b)) return false;
  std::ifstream streamA(a, std::ios::binary);
  std::ifstream streamB(b, std::ios::binary);
  if (!streamA || !streamB) return false;
  constexpr std::size_t kWindow = std::size_t{1} << 16U;
  std::vector<char> windowA(kWindow);
  std::vector<char> windowB(kWindow);
  while (true) {
    streamA.read(windowA.data(), kWindow);
    streamB.read(windowB.data(), kWindow);
    const std::streamsize count = streamA.gcount();
    if (count != streamB.gcount()) return false;
    if (!std::equal(windowA.begin(), windowA.begin() + count, windowB.begin())) return false;
    if (count == 0) return streamA.eof() && streamB.eof();
  }
}

struct Contents {
  measure::MeshDigest digest;
  std::set<std::string> attributes;
};

Result<Contents> contentsOf(const T4dReader& reader, std::size_t body,
                            const model::Progress& progress) {
  measure::MeshDigester digester;
  model::AttributeNames names(digester);
  if (auto read = reader.readThrough(body, names, progress); !read) return read.error();
  return Contents{digester.digest(), names.names()};
}

/// Metadata that are not the same, and do not make a mesh another one.
void compareMetadata(const formats::Metadata& a, const formats::Metadata& b,
                     std::vector<std::string>& messages) {
  const auto compare = [&](const char* what, const std::string& ofA, const std::string& ofB) {
    if (ofA != ofB)
      messages.push_back(fmt::format("the {} differs: '{}' and '{}'", what, ofA, ofB));
  };
  compare("generator", a.generator, b.generator);
  compare("backend", a.backend, b.backend);
  compare("upward axis", a.up, b.up);
  compare("space", a.space, b.space);
  if (a.attributes != b.attributes) {
    messages.emplace_back("the kinds or units of attributes differ");
  }
  if (a.otherJson != b.otherJson) {
    messages.emplace_back("members of the metadata that this version does not know differ");
  }
  if (nlohmann::json::parse(a.detailsJson, nullptr, false) !=
      nlohmann::json::parse(b.detailsJson, nullptr, false)) {
    messages.emplace_back("the details of the metadata differ");
  }
}

/// Whether the bodies have the same cells.
Result<bool> compareMeshes(const T4dReader& a, const T4dReader& b,
                           std::vector<std::string>& messages, const model::Progress& progress) {
  const auto& bodiesA = a.metadata().bodies;
  const auto& bodiesB = b.metadata().bodies;
  const auto indexOf = [](const std::vector<formats::BodyInfo>& bodies, const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(bodies, name, &formats::BodyInfo::name) -
                                    bodies.begin());
  };
  bool same = true;
  for (const formats::BodyInfo& body : bodiesB) {
    if (indexOf(bodiesA, body.name) < bodiesA.size()) continue;
    messages.push_back(fmt::format("only the second has a body '{}'", body.name));
    same = false;
  }
  for (std::size_t i = 0; i < bodiesA.size(); ++i) {
    const std::string& name = bodiesA[i].name;
    const std::size_t j = indexOf(bodiesB, name);
    if (j == bodiesB.size()) {
      messages.push_back(fmt::format("only the first has a body '{}'", name));
      same = false;
      continue;
    }
    const auto own = model::eachOf(progress, i, bodiesA.size());
    const std::uint64_t cellsA = a.summary(i).tetrahedra;
    const std::uint64_t cellsB = b.summary(j).tetrahedra;
    if (cellsA != cellsB) {
      messages.push_back(fmt::format(
          "body '{}' has {} tetrahedra in the first and {} in the second", name, cellsA, cellsB));
      same = false;
      continue;
    }
    const auto ofA = contentsOf(a, i, model::partOf(own, 0, 0.5));
    if (!ofA) return ofA.error();
    const auto ofB = contentsOf(b, j, model::partOf(own, 0.5, 1));
    if (!ofB) return ofB.error();
    if (ofA->digest != ofB->digest) {
      messages.push_back(
          fmt::format("body '{}' has {} tetrahedra in both, of which some differ", name, cellsA));
      same = false;
    }
    if (ofA->attributes != ofB->attributes) {
      messages.push_back(fmt::format("body '{}' has other attributes in the second", name));
    }
  }
  return same;
}

std::vector<model::Body> bodiesOf(const T4dReader& reader) {
  std::vector<model::Body> bodies;
  for (std::size_t i = 0; i < reader.bodyCount(); ++i) {
    bodies.push_back({reader.metadata().bodies[i].name, &reader.body(i)});
  }
  return bodies;
}

/// Whether the surfaces lie within the tolerance at all times that are compared.
Result<bool> compareSolids(const T4dReader& a, const T4dReader& b, const DiffOptions& options,
                           std::vector<std::string>& messages, const model::Progress& progress) {
  const std::vector<model::Body> bodiesA = bodiesOf(a);
  const std::vector<model::Body> bodiesB = bodiesOf(b);
  model::Bounds3 bounds;
  for (const T4dReader* reader : {&a, &b}) {
    for (std::size_t i = 0; i < reader->bodyCount(); ++i) bounds.add(reader->summary(i).bounds);
  }
  const double diagonal = bounds.empty() ? 0 : (bounds.max - bounds.min).stableNorm();
  const double tolerance = options.tolerance.value_or(diagonal / 1000);
  std::vector<model::Body> all = bodiesA;
  all.insert(all.end(), bodiesB.begin(), bodiesB.end());
  const model::TimeSpan span = model::timeSpanOf(all);
  std::vector<double> times = {span.begin, span.end};
  for (std::uint64_t i = 0; i < options.times; ++i) {
    times.push_back(model::dividedTime(span, 2 * i + 1, 2 * options.times));
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double time = times[i];
    const auto solidA = measure::solidAt(bodiesA, time);
    if (!solidA) return solidA.error();
    const auto solidB = measure::solidAt(bodiesB, time);
    if (!solidB) return solidB.error();
    const auto farther = measure::fartherThan(tolerance, *solidA, *solidB);
    if (!farther) return farther.error();
    if (auto on = model::report(progress, i + 1, times.size()); !on) return on.error();
    if (!*farther) continue;
    messages.push_back(
        std::isinf(**farther)
            ? fmt::format("at time {} there is a solid in one of them only", time)
            : fmt::format("at time {} a point of one surface is {:.6g} from the other; {:.6g} is "
                          "allowed",
                          time, **farther, tolerance));
    return false;
  }
  messages.push_back(fmt::format("at {} times the surfaces are within {:.6g} of each other",
                                 times.size(), tolerance));
  return true;
}

}  // namespace

Result<Diff> diff(const std::filesystem::path& a, const std::filesystem::path& b,
                  const DiffOptions& options, const model::Progress& progress) {
  const auto readerA = T4dReader::open(a, formats::T4dOpen::Whole, {}, options.maxCells);
  if (!readerA) return readerA.error();
  const auto readerB = T4dReader::open(b, formats::T4dOpen::Whole, {}, options.maxCells);
  if (!readerB) return readerB.error();
  if (haveTheSameBytes(a, b)) return Diff{SameLevel::Bytes, {}};
  Diff diff;
  const formats::Metadata& ofA = readerA->metadata();
  const formats::Metadata& ofB = readerB->metadata();
  compareMetadata(ofA, ofB, diff.messages);
  for (const auto& [what, unitA, unitB] : {std::tuple{"length", ofA.lengthUnit, ofB.lengthUnit},
                                           std::tuple{"time", ofA.timeUnit, ofB.timeUnit}}) {
    if (unitA == unitB) continue;
    diff.messages.push_back(fmt::format("the {} units differ: '{}' and '{}'", what, unitA, unitB));
    if (!unitA.empty() && !unitB.empty()) return diff;
  }
  const auto sameMesh =
      compareMeshes(*readerA, *readerB, diff.messages, model::partOf(progress, 0, 0.5));
  if (!sameMesh) return sameMesh.error();
  if (*sameMesh) {
    diff.level = SameLevel::Mesh;
    return diff;
  }
  const auto sameSolid =
      compareSolids(*readerA, *readerB, options, diff.messages, model::partOf(progress, 0.5, 1));
  if (!sameSolid) return sameSolid.error();
  if (*sameSolid) diff.level = SameLevel::Solid;
  return diff;
}

void describe(Members& members, const Diff& diff) {
  constexpr std::array kLevels = {"bytes", "mesh", "solid", "different"};
  members("same", diff.level != SameLevel::Different, "Whether they agree at some level.");
  members("level", kLevels[static_cast<std::size_t>(diff.level)],
          "The highest level at which they agree.")
      .oneOf({kLevels.begin(), kLevels.end()});
  members("messages", diff.messages, "The differences, one sentence each.");
}

namespace {

struct DiffArguments {
  std::string a;
  std::string b;
  DiffOptions how;
  bool json = false;
};

const char* levelText(SameLevel level) {
  switch (level) {
    case SameLevel::Bytes:
      return "the same bytes";
    case SameLevel::Mesh:
      return "the same mesh, stored otherwise";
    case SameLevel::Solid:
      return "the same solid, within the tolerance";
    case SameLevel::Different:
      break;
  }
  return "different";
}

int run(const DiffArguments& options) {
  Result<Diff> found;
  {
    ProgressBar bar("comparing");
    found = diff(options.a, options.b, options.how, bar.callback());
  }
  if (!found) return report(found.error());
  const bool same = found->level != SameLevel::Different;
  if (options.json) {
    printAsJson(*found);
  } else {
    print("{} and {}: {}\n", options.a, options.b, levelText(found->level));
    for (const std::string& message : found->messages) print("  {}\n", message);
  }
  return same ? kDone : kFailed;
}

}  // namespace

void addDiff(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("diff", "Check whether two .t4d files have the same bytes, mesh or solid");
  auto options = std::make_shared<DiffArguments>();
  command->add_option("A", options->a, kT4dFileHelp)->required();
  command->add_option("B", options->b, "Other file (.t4d): path or URL")->required();
  command
      ->add_option(
          "--tolerance", options->how.tolerance,
          "Maximum distance between equal solids (default: 0.001 of their common diagonal)")
      ->type_name("LENGTH")
      ->check(CLI::NonNegativeNumber)
      ->check(finiteNumber());
  command
      ->add_option("--slices", options->how.times,
                   "Number of times to compare, besides the first and the last")
      ->type_name("N")
      ->check(wholeNumber(1, 100'000))
      ->capture_default_str();
  addMaxCellsOption(*command, options->how.maxCells);
  addJsonOption<Diff>(*command, options->json, "The level at which two .t4d files agree.");
  command->footer(
      "Exit codes: 0 the same, 1 different.\n"
      "Example:\n  t4d diff bolt.t4d again.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
