#include "tools/t4d/compress.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "platform/stopwatch.h"
#include "t4d/file.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/part_option.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/version.h"

namespace t4d::tools {
namespace {

Result<void> writeSlabs(const Input& input, formats::T4dWriter& writer, Observer& observer) {
  const auto stage = observer.stage("compressing", slabCountOf(input.bodies), "slabs");
  for (std::size_t i = 0; i < input.bodies.size(); ++i) {
    const model::Source& source = *input.bodies[i].source;
    auto done = model::pump(source, writer.body(i), stage->part(source.slabCount()));
    if (!done) return done;
  }
  return {};
}

}  // namespace

Result<CompressReport> compress(const Input& input, const CompressOptions& options,
                                Observer& observer) {
  const platform::Stopwatch stopwatch;
  const auto some = partOf(input, options.part, /*ofEach=*/true);
  if (!some) return some.error();
  auto writer = formats::T4dWriter::create(options.output, metadataOf(*some, options.generator),
                                           options.writing);
  if (!writer) return writer.error();
  if (auto done = writeSlabs(*some, *writer, observer); !done) return done.error();
  const auto bytes = finishEdited(*writer, *some);
  if (!bytes) return bytes.error();
  CompressReport report;
  report.bytesBefore = input.reader ? input.reader->fileBytes() : 0;
  report.bytes = *bytes;
  report.seconds = stopwatch.seconds();
  report.losses = writer->losses();
  return report;
}

void describe(Members& members, const CompressReport& report) {
  members("bytes_before", report.bytesBefore, "Size of the file read, in bytes.")
      .joined(Joined::First);
  members("bytes", report.bytes, "Size of the file written, in bytes.").joined(Joined::Unknown);
  addCosts(members, report.seconds);
}

namespace {

struct CompressArguments {
  std::string input;
  InputOptions only;
  T4dCoding coding;
  CompressOptions compress;
  PartOption part;
  bool json = false;
};

void printReport(const CompressReport& compressed, const CompressArguments& options) {
  print("{}: {}, {:.1f} % of the {} of {}\n", options.compress.output, sizeText(compressed.bytes),
        100 * static_cast<double>(compressed.bytes) / static_cast<double>(compressed.bytesBefore),
        sizeText(compressed.bytesBefore), options.input);
  if (const auto rounding = options.coding.rounding()) print("  {}\n", *rounding);
  print("  {:.2f} s, peak memory {}\n", compressed.seconds, sizeText(peakBytes()));
}

int run(CompressArguments& options) {
  const auto input = openInput(options.input, options.only);
  if (!input) return report(input.error());
  if (const auto done = options.part.settle(mostParts(*input, /*ofEach=*/true), "slabs")) {
    return *done;
  }
  options.compress.writing = options.coding.writeOptions();
  options.compress.part = options.part.chosen();
  options.compress.generator = versionText();
  ConsoleObserver observer;
  const auto compressed = compress(*input, options.compress, observer);
  if (!compressed) return report(compressed.error());
  if (options.json) {
    const auto identity = [&] { return identityOf(*input); };
    tools::printText(options.part.inReport(Members::valueOf(*compressed), identity) + "\n");
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
  addJsonOption<CompressReport>(*command, options->json, "Sizes of a .t4d file before and after.");
  command->footer(
      "Example:\n"
      "  t4d compress goat.t4d -o small.t4d\n"
      "  t4d compress goat.t4d --grid-step 0.001 -o smaller.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
