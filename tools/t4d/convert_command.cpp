#include <algorithm>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/mesh4d/mesh4d_formats.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/version.h"
#include "tools/verbs/convert.h"

namespace t4d::tools {
namespace {

struct ConvertArguments {
  verbs::ConvertOptions convert;
  bool acceptLoss = false;
  bool json = false;
};

/// The error message if these options cannot be.
std::optional<std::string> misuseOf(const verbs::ConvertOptions& options) {
  if (verbs::formatToWrite(options).empty()) {
    return fmt::format("unsupported output extension: '{}' is not .t4d, {}; --to names the format",
                       options.output, formats::writableMesh4dExtensions());
  }
  if ((options.slabs || options.weld) && verbs::isFromT4d(options)) {
    return "--slabs and --weld are for meshes without slabs; a .t4d has them";
  }
  return std::nullopt;
}

/// The name of a format, given its id.
std::string nameOf(const std::string& format) {
  return format == verbs::kT4dFormat ? ".t4d" : std::string(formats::mesh4dFormat(format)->name);
}

std::string titleOf(const verbs::ConvertReport& report) {
  std::string title = nameOf(report.from);
  // The name of an OFF file says its dialect.
  if (!report.dialect.empty() && title.find(report.dialect) == title.npos) {
    title += " (" + report.dialect + ")";
  }
  return title;
}

/// Notes on a choice of options that is allowed, but may be a mistake.
std::vector<std::string> noticesOfChoices(const verbs::ConvertOptions& options) {
  std::vector<std::string> notices;
  const std::string written = verbs::formatToWrite(options);
  if (options.slabs && written != verbs::kT4dFormat) {
    notices.push_back(fmt::format("{}: {} has no slabs; --slabs only splits tetrahedra at the cuts",
                                  options.output, nameOf(written)));
  }
  return notices;
}

void printReport(const verbs::ConvertReport& report, const std::string& output) {
  print("{}: {}, {}, {}; {}, {}\n", output, counted(report.bodies, "body", "bodies"),
        counted(report.vertices, "vertex", "vertices"),
        counted(report.tetrahedra, "tetrahedron", "tetrahedra"),
        report.closed ? "closed" : "NOT CLOSED", report.oriented ? "oriented" : "NOT ORIENTED");
  print("  {} to {}, {:.2f} s, peak memory {}\n", titleOf(report), nameOf(report.to),
        report.seconds, sizeText(peakBytes()));
}

int run(ConvertArguments& arguments) {
  verbs::ConvertOptions& options = arguments.convert;
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  options.generator = versionText();
  ConsoleObserver observer;
  const auto done = verbs::convert(options, observer);
  if (!done) return report(done.error());
  printNotices(done->notices);
  printNotices(noticesOfChoices(options));
  if (!done->closed || !done->oriented) {
    printNotices({fmt::format("{}: the mesh is {}: slices and volumes of it mean nothing",
                              options.output, done->closed ? "not oriented" : "not closed")});
  }
  if (arguments.json) {
    printAsJson(*done);
  } else {
    printReport(*done, options.output);
  }
  const int code = reportLosses(done->losses);
  return arguments.acceptLoss ? kDone : code;
}

/// The id of a format of 4D meshes.
CLI::Validator formatId(bool written) {
  std::vector<std::string> ids = {std::string(verbs::kT4dFormat)};
  for (const formats::Mesh4dFormat& format : formats::mesh4dFormats()) {
    if (written ? format.write != nullptr : format.read != nullptr) ids.emplace_back(format.id);
  }
  return CLI::IsMember(ids);
}

}  // namespace

void addConvert(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("convert", "Convert a 4D mesh between file formats");
  auto options = std::make_shared<ConvertArguments>();
  verbs::ConvertOptions& convert = options->convert;
  command
      ->add_option("IN", convert.input,
                   "Input file, in a format that `t4d formats` lists; .t4d also by URL")
      ->required();
  command
      ->add_option("OUT", convert.output,
                   fmt::format("Output file: .t4d, {}", formats::writableMesh4dExtensions()))
      ->required()
      ->check(someName());
  command->add_option("--from", convert.from, "Format of IN (default: from its content)")
      ->check(formatId(false))
      ->type_name("FORMAT");
  command->add_option("--to", convert.to, "Format of OUT (default: from its extension)")
      ->check(formatId(true))
      ->type_name("FORMAT");
  command
      ->add_option("--slabs", convert.slabs,
                   "Cut into N slabs, splitting tetrahedra (default: cut where none is split)")
      ->check(wholeNumber(1, 1'000'000))
      ->type_name("N");
  command
      ->add_option("--weld", convert.weld,
                   "Merge vertices within this distance per axis (default: equal ones, if open)")
      ->check(numberFromZero())
      ->type_name("DISTANCE");
  command->add_flag("--allow-open", convert.allowOpen,
                    "Accept meshes that are open or cannot be oriented");
  command->add_flag("--accept-loss", options->acceptLoss,
                    "Exit with 0 even if data was lost (losses are still listed)");
  addNoPartOption(*command,
                  "converting cannot be divided: other formats hold a mesh as one; join the parts "
                  "first (t4d join), or write a .t4d in parts (t4d compress)");
  addMaxCellsOption(*command, convert.maxCells);
  addJsonOption<verbs::ConvertReport>(
      *command, options->json, "The result of a conversion; numbers are for all bodies together.");
  command->footer(
      "Example:\n  t4d convert bolt.t4d bolt.vtu --accept-loss\n"
      "  t4d convert polytope.off polytope.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
