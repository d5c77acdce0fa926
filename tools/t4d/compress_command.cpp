#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/version.h"
#include "tools/verbs/compress.h"

namespace t4d::tools {
namespace {

struct CompressArguments {
  std::string input;
  InputOptions only;
  T4dCoding coding;
  verbs::CompressOptions compress;
  PartOption part;
  bool json = false;
};

void printReport(const verbs::CompressReport& compressed, const CompressArguments& options) {
  print("{}: {}, {:.1f} % of the {} of {}\n", options.compress.output, sizeText(compressed.bytes),
        100 * static_cast<double>(compressed.bytes) / static_cast<double>(compressed.bytesBefore),
        sizeText(compressed.bytesBefore), options.input);
  if (const auto rounding = options.coding.rounding()) print("  {}\n", *rounding);
  print("  {:.2f} s, peak memory {}\n", compressed.seconds, sizeText(peakBytes()));
}

int run(CompressArguments& options) {
  const auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  if (const auto done = options.part.settle(verbs::mostParts(*input, /*ofEach=*/true), "slabs")) {
    return *done;
  }
  options.compress.writing = options.coding.writeOptions();
  options.compress.part = options.part.chosen();
  options.compress.generator = versionText();
  ConsoleObserver observer;
  const auto compressed = verbs::compress(*input, options.compress, observer);
  if (!compressed) return report(compressed.error());
  if (options.json) {
    const auto identity = [&] { return identityOf(*input); };
    tools::printText(options.part.inReport(verbs::Members::valueOf(*compressed), identity) + "\n");
  } else {
    printReport(*compressed, options);
  }
  return reportLosses(compressed->losses);
}

}  // namespace

void addCompress(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("compress", "Rewrite a .t4d file, smaller or with less precision");
  auto options = std::make_shared<CompressArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->only.addTo(*command);
  addT4dOutputOption(*command, options->compress.output);
  options->coding.compression = 19;
  options->coding.addTo(*command);
  options->part.addTo(*command,
                      "Rewrite only part K of N of the slabs; `t4d join` joins the parts");
  addJsonOption<verbs::CompressReport>(*command, options->json,
                                       "Sizes of a .t4d file before and after.");
  command->footer(
      "Example:\n"
      "  t4d compress goat.t4d -o small.t4d\n"
      "  t4d compress goat.t4d --grid-step 0.001 -o smaller.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
