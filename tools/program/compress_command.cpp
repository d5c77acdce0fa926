#include <chrono>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/writer.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/input_options.h"
#include "tools/program/option_checks.h"
#include "tools/program/part_option.h"
#include "tools/program/t4d_output.h"
#include "tools/program/version.h"

namespace t4d::tools {
namespace {

struct CompressArguments {
  std::string input;
  InputOptions only;
  std::string output;
  T4dCoding coding;
  PartOption part;
  bool json = false;
};

int run(const CompressArguments& options) {
  if (const auto misuse = misuseOfOutput(options.output, {&options.input, 1})) {
    return wrongUsage(*misuse);
  }
  const auto begin = std::chrono::steady_clock::now();
  auto whole = verbs::openInput(options.input, options.only);
  if (!whole) return report(whole.error());
  if (const auto done = options.part.settle(verbs::mostParts(*whole, /*ofEach=*/true), "slabs")) {
    return *done;
  }
  const auto input = verbs::partOf(*whole, options.part.chosen(), /*ofEach=*/true);
  if (!input) return report(input.error());
  auto writer = formats::T4dWriter::create(options.output, metadataOf(*input, versionText()),
                                           options.coding.writeOptions());
  if (!writer) return report(writer.error());
  {
    ProgressBar bar("compressing", verbs::slabCountOf(input->bodies), "slabs");
    for (std::size_t i = 0; i < input->bodies.size(); ++i) {
      auto done = model::pump(*input->bodies[i].source, writer->body(i),
                              bar.part(input->bodies[i].source->slabCount()));
      if (!done) return report(done.error());
    }
  }
  const auto bytes = finishEdited(*writer, *input);
  if (!bytes) return report(bytes.error());
  const std::uint64_t before = input->reader->fileBytes();
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json) {
    nlohmann::ordered_json result = {{"bytes_before", before},
                                     {"bytes", *bytes},
                                     {"seconds", seconds},
                                     {"peak_bytes", peakBytes()}};
    if (options.part.isGiven()) result["part"] = options.part.json(identityOf(*whole));
    printJson(result);
  } else {
    print("{}: {}, {:.1f} % of the {} of {}\n", options.output, sizeText(*bytes),
          100 * static_cast<double>(*bytes) / static_cast<double>(before), sizeText(before),
          options.input);
    if (const auto rounding = options.coding.rounding()) print("  {}\n", *rounding);
    print("  {:.2f} s, peak memory {}\n", seconds, sizeText(peakBytes()));
  }
  return reportLosses(writer->losses());
}

}  // namespace

void addCompress(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("compress", "Rewrite a .t4d file, smaller or with less precision");
  auto options = std::make_shared<CompressArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->only.addTo(*command);
  addT4dOutputOption(*command, options->output);
  options->coding.compression = 19;
  options->coding.addTo(*command);
  options->part.addTo(*command,
                      "Rewrite only part K of N of the slabs; `t4d join` joins the parts");
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example:\n"
      "  t4d compress goat.t4d -o small.t4d\n"
      "  t4d compress goat.t4d --grid-step 0.001 -o smaller.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
