#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/merge.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/option_checks.h"
#include "tools/program/t4d_output.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct MergeArguments {
  std::vector<std::string> files;
  std::string output;
  bool json = false;
};

int run(const MergeArguments& options) {
  if (const auto misuse = misuseOfOutput(options.output, options.files)) return wrongUsage(*misuse);
  Result<formats::MergeReport> merged;
  {
    ProgressBar bar("merging");
    merged = formats::mergeT4d({options.files.begin(), options.files.end()}, options.output,
                               bar.callback());
  }
  if (!merged) return report(merged.error());
  printNotices(merged->notices);
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  ordered_json bodies = ordered_json::array();
  for (const formats::MergeReport::Body& body : merged->bodies) {
    vertices += body.summary.vertices;
    tetrahedra += body.summary.tetrahedra;
    bodies.push_back({{"name", body.name},
                      {"file", options.files[body.file]},
                      {"slabs", body.summary.slabs},
                      {"vertices", body.summary.vertices},
                      {"tetrahedra", body.summary.tetrahedra}});
  }
  if (options.json) {
    printJson({{"files", options.files.size()},
               {"bodies", bodies},
               {"vertices", vertices},
               {"tetrahedra", tetrahedra},
               {"bytes", merged->bytes}});
  } else {
    print("{}: {} of {}, {}\n", options.output, counted(merged->bodies.size(), "body", "bodies"),
          counted(options.files.size(), "file"), sizeText(merged->bytes));
    print("  {}, {}\n", counted(vertices, "vertex", "vertices"),
          counted(tetrahedra, "tetrahedron", "tetrahedra"));
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
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example:\n"
      "  t4d sweep bolt.obj --motion screw-in.json --up z -o bolt.t4d\n"
      "  t4d sweep torus.obj --motion screw-in.json --up z -o ring.t4d\n"
      "  t4d merge bolt.t4d ring.t4d -o both.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
