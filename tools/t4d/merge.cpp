#include "tools/t4d/merge.h"

#include <fmt/format.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/t4d_output.h"

namespace t4d::tools {
std::uint64_t MergeReport::vertices() const {
  std::uint64_t sum = 0;
  for (const Body& body : bodies) sum += body.summary.vertices;
  return sum;
}

std::uint64_t MergeReport::tetrahedra() const {
  std::uint64_t sum = 0;
  for (const Body& body : bodies) sum += body.summary.tetrahedra;
  return sum;
}

Result<MergeReport> merge(const std::vector<std::string>& files, const std::string& output,
                          Observer& observer) {
  const auto stage = observer.stage("merging");
  auto merged = formats::mergeT4d({files.begin(), files.end()}, output, stage->callback());
  if (!merged) return merged.error();
  return MergeReport{std::move(*merged), files};
}

void describe(Members& members, const MergeReport& report) {
  members("files", report.files.size(), "Files that were merged.").atLeast(1);
  members("bodies", report.bodies, "Bodies of the file, in its order.",
          [&](Members& own, const MergeReport::Body& body) {
            own("name", body.name,
                "Name of the body; with a number behind it where another one had it first.");
            own("file", report.files.empty() ? std::string() : report.files[body.file],
                "The file that it is from.");
            own("slabs", body.summary.slabs, "Slabs of the body.");
            own("vertices", body.summary.vertices, "Vertices of the body.");
            own("tetrahedra", body.summary.tetrahedra, "Cells of the body.");
          })
      .itemsFrom(1);
  members("vertices", report.vertices(), "Vertices of all bodies.");
  members("tetrahedra", report.tetrahedra(), "Cells of all bodies.");
  members("bytes", report.bytes, "Size of the file.");
}

namespace {

struct MergeArguments {
  std::vector<std::string> files;
  std::string output;
  bool json = false;
};

int run(const MergeArguments& options) {
  ConsoleObserver observer;
  const auto merged = merge(options.files, options.output, observer);
  if (!merged) {
    Error error = merged.error();
    if (error.remedy == Remedy::Units) {  // no option of this verb leaves them as they are
      error.remedy = Remedy::None;
      error.message +=
          ": t4d transform --scale FACTOR --length-unit NAME, --time-scale FACTOR --time-unit "
          "NAME, "
          "or --rotate 1 0 0 90 --up AXIS";
    }
    return report(error);
  }
  printNotices(merged->notices);
  if (options.json) {
    printAsJson(*merged);
  } else {
    print("{}: {} of {}, {}\n", options.output, counted(merged->bodies.size(), "body", "bodies"),
          counted(options.files.size(), "file"), sizeText(merged->bytes));
    print("  {}, {}\n", counted(merged->vertices(), "vertex", "vertices"),
          counted(merged->tetrahedra(), "tetrahedron", "tetrahedra"));
  }
  return reportLosses(merged->losses);
}

}  // namespace

void addMerge(CLI::App& app, int& exitCode) {
  auto* command =
      app.add_subcommand("merge", "Put the bodies of several .t4d files into one without decoding");
  auto options = std::make_shared<MergeArguments>();
  command->add_option("FILE", options->files, "Input files (.t4d)")->required();
  addT4dOutputOption(*command, options->output);
  addJsonOption<MergeReport>(*command, options->json,
                             "What was written: the bodies of several files in one.");
  command->footer(
      "Example:\n"
      "  t4d sweep bolt.obj --motion screw-in.json --up z -o bolt.t4d\n"
      "  t4d sweep torus.obj --motion screw-in.json --up z -o ring.t4d\n"
      "  t4d merge bolt.t4d ring.t4d -o both.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
