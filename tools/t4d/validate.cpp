#include <functional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/url.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/hints.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/validate_parts.h"
#include "tools/t4d/validation.h"

namespace t4d::tools {
namespace {

void printText(const std::string& path, const Validation& validation) {
  print("{}: {}\n", path, validation.valid() ? "valid" : "INVALID");
  if (validation.mesh) {
    const measure::MeshReport& mesh = *validation.mesh;
    const auto yes = [](bool value) { return value ? "yes" : "NO"; };
    print("  closed {}, oriented {}", yes(mesh.closed), yes(mesh.oriented));
    if (mesh.vertexLinksOk) print(", vertex links are spheres {}", yes(*mesh.vertexLinksOk));
    print("\n  {}, {} in {}, {}\n", counted(mesh.vertices, "vertex", "vertices"),
          counted(mesh.tetrahedra, "tetrahedron", "tetrahedra"), counted(mesh.slabs, "slab"),
          counted(mesh.components, "component"));
    print(
        "  {}3-volume of the boundary {:.12g}, {}\n",
        mesh.closed && mesh.oriented ? fmt::format("hypervolume {:.12g}, ", mesh.hypervolume) : "",
        mesh.boundaryVolume, counted(mesh.degenerateCells, "degenerate cell"));
  }
  for (const measure::Issue& issue : validation.issues.issues) {
    static constexpr const char* kNames[] = {"error", "warning", "information", "hint"};
    std::string where;
    if (issue.slab) where += fmt::format(" slab {}", *issue.slab);
    if (issue.offset) where += fmt::format(" at byte {}", *issue.offset);
    print("  {}{}: {} [{}]\n", kNames[static_cast<int>(issue.severity)], where, issue.message,
          issue.code);
  }
}

struct ValidateArguments {
  std::string path;
  bool deep = false;
  bool json = false;
  std::optional<std::uint64_t> maxCells;
  PartOption part;
};

using Completion = std::function<nlohmann::ordered_json(nlohmann::ordered_json report)>;

void printReport(const ValidateArguments& options, const Validation& validation,
                 const Completion& complete = std::identity()) {
  if (options.json) {
    printJson(complete(Members::valueOf(validation)));
    return;
  }
  const std::string& path = options.path;
  printText(path == "-" ? "standard input" : formats::shownName(path), validation);
}

/// Into how many parts the file can be divided, and what is the same in all of them.
Result<std::uint64_t> mostParts(const ValidateArguments& options, nlohmann::ordered_json& input) {
  auto opened = openInput(options.path, {{}, options.maxCells});
  if (!opened) return opened.error();
  input = identityOf(*opened);
  return mostParts(*opened);
}

int runPart(const ValidateArguments& options) {
  nlohmann::ordered_json input;
  const auto most = mostParts(options, input);
  // A file that cannot be opened is invalid in each part, which says why.
  if (!most && !options.part.isGiven()) return report(most.error());
  if (most) {
    if (const auto done = options.part.settle(*most, "slabs")) return *done;
  }
  Result<PartValidation> found;
  {
    ProgressBar bar("validating");
    found = validatePart(options.path, {.vertexLinks = options.deep}, options.part.chosen(),
                         bar.callback(), options.maxCells);
  }
  if (!found) return report(found.error());
  Validation validation = validationOf(*found);
  validation.deep = options.deep;
  printReport(options, validation, [&](nlohmann::ordered_json report) {
    return options.part.reportOf(std::move(report), input, stateOf(*found));
  });
  return validation.valid() ? kDone : kInvalid;
}

int run(const ValidateArguments& options) {
  if (options.part.isAsked()) return runPart(options);
  Result<Validation> validation;
  {
    ProgressBar bar("validating");
    validation =
        validate(options.path, {.vertexLinks = options.deep}, bar.callback(), options.maxCells);
  }
  if (!validation) return report(validation.error());
  validation->deep = options.deep;
  printReport(options, *validation);
  // A file that can be read to its end needs no recovery.
  if (!validation->mesh) sayHint(hintForFile(options.path));
  return validation->valid() ? kDone : kInvalid;
}

}  // namespace

void addValidate(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "validate", "Check every byte of a .t4d file, and that its mesh is closed and oriented");
  auto options = std::make_shared<ValidateArguments>();
  command->add_option("FILE", options->path, std::string(kT4dFileHelp) + kOrPipeHelp)->required();
  command->add_flag("--deep", options->deep, "Also check that every vertex link is a sphere");
  options->part.addTo(*command,
                      "Check only part K of N of the slabs; `t4d join` joins the reports");
  addJsonOption<Validation>(
      *command, options->json,
      "The result of checking a .t4d file. The measures are totals over all bodies, and null if "
      "the file cannot be read that far.");
  addMaxCellsOption(*command, options->maxCells);
  command->footer("Examples:\n  t4d validate bolt.t4d --deep\n  zcat bolt.t4d.gz | t4d validate -");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
