#include <fmt/format.h>

#include "formats/output_file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/simplify_page.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/version.h"
#include "tools/verbs/simplify.h"

namespace t4d::tools {
namespace {

struct SimplifyArguments {
  std::string input;
  InputOptions only;
  verbs::SimplifyOptions simplify;
  std::optional<model::Part> part;
  std::string html;
  bool json = false;
};

std::string percentOf(std::uint64_t part, std::uint64_t whole) {
  return fmt::format("{:.3g} %", 100.0 * static_cast<double>(part) /
                                     static_cast<double>(std::max<std::uint64_t>(whole, 1)));
}

void printReport(const verbs::SimplifyReport& report, const std::string& output) {
  const edit::SimplifyReport& mesh = report.mesh;
  print("{}: {} of {} ({})\n", output, counted(mesh.cells, "cell"), grouped(mesh.cellsBefore),
        percentOf(mesh.cells, mesh.cellsBefore));
  print("  {} of {}\n", counted(mesh.vertices, "vertex", "vertices"), grouped(mesh.verticesBefore));
  print("  hypervolume {:.12g}, before {:.12g}\n", mesh.hypervolume, mesh.hypervolumeBefore);
  if (mesh.maxError) print("  no slice is farther than {:.4g} from the original\n", *mesh.maxError);
  print("  measured: at most {:.4g}, at time {:.6g}; in the mean {:.4g}\n", report.measuredError,
        report.measuredErrorTime, report.meanError);
  const auto before = report.heights(0);
  const auto after = report.heights(1);
  print("  height of cells: least {:.3g}, before {:.3g}; median {:.3g}, before {:.3g}\n",
        after.min(), before.min(), after.quantile(0.5), before.quantile(0.5));
  print("  {}, before {}, {:.2f} s, peak memory {}\n", sizeText(report.bytes),
        sizeText(report.bytesBefore), report.seconds, sizeText(peakBytes()));
}

Result<void> writePage(const SimplifyArguments& options, const formats::Metadata& metadata,
                       const verbs::SimplifyReport& report, formats::OutputFile& file) {
  const std::string page = simplifyPage(options.input, options.simplify.output, metadata, report);
  return file.finish(page);
}

int run(SimplifyArguments& options) {
  const std::array outputs = {options.simplify.output, options.html};
  if (auto good = checkOutputs(outputs, {&options.input, 1}); !good) return report(good.error());
  std::optional<formats::OutputFile> page;
  if (!options.html.empty()) {
    auto file = formats::OutputFile::create(options.html);
    if (!file) return report(file.error());
    page = std::move(*file);
    options.simplify.pairs = 3;
  }
  const auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  options.simplify.generator = versionText();
  options.simplify.part = options.part.value_or(model::Part());
  ConsoleObserver observer;
  const auto done = verbs::simplify(*input, options.simplify, observer);
  if (!done) return report(done.error());
  if (options.json) {
    printAsJson(*done);
  } else {
    printReport(*done, options.simplify.output);
  }
  const int exitCode = reportLosses(done->losses);
  if (page) {
    const auto written = writePage(options, input->metadata, *done, *page);
    if (!written) return report(written.error());
  }
  return exitCode;
}

}  // namespace

void addSimplify(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "simplify", "Reduce the number of cells of a 4D mesh, with a stated error");
  auto options = std::make_shared<SimplifyArguments>();
  verbs::SimplifyOptions& simplify = options->simplify;
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  addT4dOutputOption(*command, simplify.output);
  command
      ->add_option("--max-error", simplify.maxError,
                   "Maximum distance of slices (default: 0.001 of the size of each body)")
      ->check(numberAboveZero());
  auto* ratio = command->add_option("--ratio", simplify.ratio, "Part of the cells to keep, up to 1")
                    ->check(numberAboveZero());
  command->add_option("--cells", simplify.cells, "Number of cells to keep, of all bodies together")
      ->check(wholeNumber(1, std::uint64_t{1} << 62))
      ->excludes(ratio);
  command
      ->add_option("--time-scale", simplify.timeScale,
                   "Length equal to one unit of time (default: mean normal speed of the surface)")
      ->check(numberAboveZero());
  command
      ->add_option("--preserve", simplify.preserve,
                   "Cell attribute whose borders are kept, such as triangle or label")
      ->check(someName());
  command
      ->add_option("--window", simplify.windowSlabs,
                   "Number of slabs to join to one (default: 250,000 cells)")
      ->check(wholeNumber(1, std::uint64_t{1} << 32));
  addPartOption(*command, options->part, "Simplify only part K of N; `t4d join` joins the parts");
  addCompressionOption(*command, simplify.compression);
  options->only.addTo(*command);
  command
      ->add_option("--html", options->html,
                   "Write a page with the numbers and slices of both side by side")
      ->check(htmlFile());
  addJsonOption<verbs::SimplifyReport>(
      *command, options->json, "A 4D mesh with fewer cells, and its distance from the given one.");
  command->footer(
      "Example:\n  t4d simplify ball.t4d --max-error 0.05 -o small.t4d\n"
      "  t4d simplify ball.t4d --ratio 0.1 -o tenth.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
