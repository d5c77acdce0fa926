#include "tools/t4d/recover.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/optional_chunks.h"
#include "model/progress.h"
#include "t4d/file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

/// Limits the size of the metadata.
constexpr std::size_t kMostGaps = 1000;

/// Times between slabs at which a body does not exist.
ordered_json gapsOf(formats::T4dSalvage& salvage) {
  ordered_json gaps = ordered_json::array();
  for (std::size_t i = 0; i < salvage.metadata().bodies.size(); ++i) {
    const model::Source& slabs = salvage.body(i);
    for (std::size_t k = 1; k < slabs.slabCount(); ++k) {
      const double begin = slabs.timeSpan(k - 1).end;
      const double end = slabs.timeSpan(k).begin;
      if (begin == end || gaps.size() == kMostGaps) continue;
      gaps.push_back({{"body", salvage.metadata().bodies[i].name}, {"begin", begin}, {"end", end}});
    }
  }
  return gaps;
}

/// The metadata of the recovered file: the original, with our generator and a note on its origin.
formats::Metadata metadataOf(formats::T4dSalvage& salvage, const std::filesystem::path& input,
                             const std::string& generator) {
  formats::Metadata metadata = salvage.metadata();
  ordered_json details = ordered_json::parse(metadata.detailsJson);
  ordered_json recovered = {{"from", input.filename().string()},
                            {"slabs_saved", salvage.slabsSaved()}};
  if (const auto known = salvage.slabsKnown()) recovered["slabs_known"] = *known;
  if (!metadata.generator.empty()) recovered["generator"] = metadata.generator;
  if (!salvage.losses().empty()) recovered["gaps"] = gapsOf(salvage);
  details["recovered"] = std::move(recovered);
  metadata.detailsJson = details.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  metadata.generator = generator;
  return metadata;
}

std::string atEnd(const edit::RunEnd& end) {
  return fmt::format("where it {} at time {}", end.begin ? "begins" : "ends", end.time);
}

}  // namespace

Result<RecoverReport> recover(const std::filesystem::path& input,
                              const std::filesystem::path& output, const RecoverOptions& options,
                              const model::Progress& progress) {
  // Reading, writing and validating take about the same time.
  const auto third = [&](int index) { return model::eachOf(progress, index, 3); };
  auto salvage = formats::T4dSalvage::open(input, third(0));
  if (!salvage) return salvage.error();
  RecoverReport report;
  report.input = input.string();
  report.output = output.string();
  report.slabsSaved = salvage->slabsSaved();
  report.slabsKnown = salvage->slabsKnown();
  report.metadataSaved = salvage->metadataSaved();
  report.lost = salvage->losses();
  if (report.slabsSaved == 0) return report;
  const bool damaged = !report.lost.empty();

  const formats::Metadata metadata = metadataOf(*salvage, input, options.generator);
  auto writer = formats::T4dWriter::create(output, metadata);
  if (!writer) return writer.error();
  std::uint64_t before = 0;
  for (std::size_t i = 0; i < metadata.bodies.size(); ++i) {
    const model::Source& slabs = salvage->body(i);
    edit::RunCloser closer(writer->body(i));
    const auto share = [&](std::uint64_t done) { return double(done) / double(report.slabsSaved); };
    const auto own = model::partOf(third(1), share(before), share(before + slabs.slabCount()));
    if (auto pumped = pump(slabs, closer, own); !pumped) return pumped.error();
    before += slabs.slabCount();
    auto ends = closer.finish();
    if (!ends) return ends.error();
    for (const edit::RunEnd& end : *ends) {
      const std::string& name = metadata.bodies[i].name;
      const std::uint64_t offset = salvage->slabOffset(i, end.slab);
      if (end.open) {
        const std::string what =
            fmt::format("the body '{}' stays open {}: {}", name, atEnd(end), *end.open);
        report.lost.push_back({offset, what, {}});
        continue;
      }
      report.closed.push_back({name, end});
      // Nothing was lost here, but the cap changes the mesh.
      if (!damaged) {
        const std::string what =
            fmt::format("the body '{}' was open {}; a cap was added there", name, atEnd(end));
        report.lost.push_back({offset, what, {}});
      }
    }
  }
  if (auto kept = writer->keep(salvage->optionalChunks()); !kept) return kept.error();
  const auto addLost = [&](const formats::ChunkFile& /*file*/,
                           const formats::ChunkHeader& header) -> Result<void> {
    if (formats::isSafeToCopy(header.type)) return {};
    formats::LostChunks lost;
    lost.add(header);
    report.lost.push_back({header.offset, lost.lines().front(), {}});
    return {};
  };
  if (auto added = salvage->optionalChunks().each(addLost); !added) return added.error();
  if (auto bytes = writer->finish(); !bytes) return bytes.error();
  std::stable_sort(report.lost.begin(), report.lost.end(),
                   [](const auto& a, const auto& b) { return a.offset < b.offset; });
  auto validation = validate(output, {}, third(2));
  if (!validation) return validation.error();
  report.validation = std::move(*validation);
  return report;
}

void describe(Members& members, const RecoverReport& report) {
  const std::optional<Validation>& validation = report.validation;
  members("input", report.input, "The damaged file, as given.").notEmpty();
  members("output", validation ? std::optional(report.output) : std::nullopt,
          "The new file, as given; null if none was written.")
      .notEmpty();
  members("slabs_saved", report.slabsSaved,
          "Slabs of the damaged file that are in the output. Caps that were added do not count.");
  members("slabs_known", report.slabsKnown,
          "Slabs of the damaged file according to its index or end mark; null if both are lost.");
  members("metadata_saved", report.metadataSaved,
          "Whether HEAD (names of bodies, units, axes, details) is undamaged.");
  members(
      "lost", report.lost,
      "The losses, in the order of offsets; empty if the file was undamaged and its mesh closed. "
      "For an undamaged file, the caps that were added.",
      [](Members& own, const formats::T4dLoss& loss) {
        const auto ofTime = [&](double model::TimeSpan::*end) {
          return loss.time ? std::optional((*loss.time).*end) : std::nullopt;
        };
        own("offset", loss.offset, "Byte in the damaged file.");
        own("what", loss.what, "The loss, in words.").notEmpty();
        own("time_begin", ofTime(&model::TimeSpan::begin),
            "First time of the slab, if known; otherwise null.");
        own("time_end", ofTime(&model::TimeSpan::end),
            "Last time of the slab, if known; otherwise null.");
      });
  members("caps", report.closed, "Where slabs are missing and the mesh was closed by a cap.",
          [](Members& own, const RecoverCap& cap) {
            own("body", cap.body, "Name of the body.").notEmpty();
            own("time", cap.end.time, "Time of the cap, in time units.");
            own("begin", cap.end.begin,
                "True if the body begins here again; false if it ends here.");
            own("triangles", cap.end.triangles,
                "Triangles of the solid's surface at this time; the cap has a cell for each.")
                .atLeast(1);
          });
  members("valid", validation ? std::optional(validation->valid()) : std::nullopt,
          "Whether t4d validate finds no error in the output; null if there is no output.");
  members(
      "hypervolume",
      validation && validation->mesh ? std::optional(validation->mesh->hypervolume) : std::nullopt,
      "Hypervolume that the output encloses, in cubed length units times time units. Null if "
      "there is no output, or if it is too large for a double.");
  std::vector<std::string> errors;
  for (const measure::Issue& issue :
       validation ? validation->issues.issues : std::vector<measure::Issue>()) {
    if (issue.severity == measure::Severity::Error) errors.push_back(issue.message);
  }
  members("errors", errors,
          "Errors that t4d validate finds in the output, the first ten of each code and body.");
}

namespace {

/// Maximum number of lines printed of each kind; the JSON output has all.
constexpr std::size_t kLines = 20;

void printText(const std::string& output, const RecoverReport& report) {
  const std::uint64_t of = report.slabsKnown.value_or(report.slabsSaved);
  print("{}: {}{} slab{} saved\n", output, grouped(report.slabsSaved),
        report.slabsKnown ? " of " + grouped(of) : "", of == 1 ? "" : "s");
  for (std::size_t i = 0; i < std::min(kLines, report.closed.size()); ++i) {
    const auto& [body, end] = report.closed[i];
    print("  closed '{}' where it {} at time {}: a cap over {} triangles\n", body,
          end.begin ? "begins" : "ends", end.time, grouped(end.triangles));
  }
  if (report.closed.size() > kLines) {
    print("  and {} more caps\n", grouped(report.closed.size() - kLines));
  }
  const Validation& validation = *report.validation;
  print("  {}", validation.valid() ? "valid" : "INVALID");
  if (validation.mesh) {
    print(": closed {}, oriented {}; hypervolume {:.12g}", validation.mesh->closed ? "yes" : "NO",
          validation.mesh->oriented ? "yes" : "NO", validation.mesh->hypervolume);
  }
  print("\n");
  for (const measure::Issue& issue : validation.issues.issues) {
    if (issue.severity == measure::Severity::Error) print("  error: {}\n", issue.message);
  }
}

/// One line per loss; consecutive slabs lost for the same reason share one.
std::vector<std::string> linesOf(const std::vector<formats::T4dLoss>& lost) {
  std::vector<std::string> lines;
  for (auto first = lost.begin(); first != lost.end();) {
    const auto end = std::find_if(first, lost.end(), [&](const formats::T4dLoss& loss) {
      return loss.what != first->what || !loss.time;
    });
    const auto last = end == first ? first : end - 1;
    std::string line = fmt::format("byte {}", first->offset);
    if (last != first) line += fmt::format(" to {}, {} times", last->offset, end - first);
    line += ": " + first->what;
    if (first->time) line += fmt::format(" (time {} to {})", first->time->begin, last->time->end);
    lines.push_back(std::move(line));
    first = last + 1;
  }
  return lines;
}

void printLosses(const std::vector<formats::T4dLoss>& lost) {
  std::vector<std::string> lines = linesOf(lost);
  if (lines.size() > kLines) {
    const std::size_t more = lines.size() - kLines;
    lines.resize(kLines);
    lines.push_back(fmt::format("and {} more; --json lists all", grouped(more)));
  }
  reportLosses(lines);
}

int run(const std::string& input, const std::string& output, bool json) {
  Result<RecoverReport> recovered;
  {
    ProgressBar bar("recovering");
    recovered = recover(input, output, {.generator = std::string(versionText())}, bar.callback());
  }
  if (!recovered) return report(recovered.error());
  printLosses(recovered->lost);
  if (json) printAsJson(*recovered);
  if (!recovered->validation) {
    say(input + ": no closed solid could be recovered; nothing was written");
    return kInvalid;
  }
  if (!json) printText(output, *recovered);
  if (!recovered->validation->valid()) return kFailed;
  return recovered->lost.empty() ? kDone : kLoss;
}

}  // namespace

void addRecover(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("recover", "Save the undamaged part of a .t4d file as a valid file");
  auto input = std::make_shared<std::string>();
  auto output = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  command->add_option("FILE", *input, "Damaged .t4d file (not modified)")->required();
  command->add_option("-o,--output", *output, "Output file (.t4d)")
      ->required()
      ->check(someName())
      ->check(outputFile({".t4d"}));
  addJsonOption<RecoverReport>(
      *command, *json,
      "What was saved from a damaged .t4d file, and what was lost. Also printed if nothing could "
      "be saved (exit code 4) or the new file is not valid (exit code 1).");
  command->footer("Example:\n  t4d recover broken.t4d -o fixed.t4d");
  command->callback([=, &exitCode] { exitCode = run(*input, *output, *json); });
}

}  // namespace t4d::tools
