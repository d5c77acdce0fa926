#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/join.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/option_checks.h"
#include "tools/program/t4d_output.h"

namespace t4d::tools {
namespace {

struct JoinArguments {
  std::vector<std::string> parts;
  std::string output;
  bool json = false;
};

int run(const JoinArguments& options) {
  if (const auto misuse = misuseOfOutput(options.output, options.parts)) return wrongUsage(*misuse);
  Result<formats::JoinReport> joined;
  {
    ProgressBar bar("joining");
    joined = formats::joinT4d({options.parts.begin(), options.parts.end()}, options.output,
                              bar.callback());
  }
  if (!joined) return report(joined.error());
  std::uint64_t slabs = 0;
  std::uint64_t vertices = 0;
  std::uint64_t tetrahedra = 0;
  for (const formats::BodySummary& body : joined->bodies) {
    slabs += body.slabs;
    vertices += body.vertices;
    tetrahedra += body.tetrahedra;
  }
  if (options.json) {
    printJson({{"parts", options.parts.size()},
               {"slabs", slabs},
               {"vertices", vertices},
               {"tetrahedra", tetrahedra},
               {"bytes", joined->bytes}});
  } else {
    print("{}: {} of {}, {}\n", options.output, counted(slabs, "slab"),
          counted(options.parts.size(), "file"), sizeText(joined->bytes));
    print("  {}, {}\n", counted(vertices, "vertex", "vertices"),
          counted(tetrahedra, "tetrahedron", "tetrahedra"));
  }
  return reportLosses(joined->losses);
}

}  // namespace

void addJoin(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("join", "Join consecutive .t4d files without decoding them");
  command->alias("concat");
  auto options = std::make_shared<JoinArguments>();
  command->add_option("PART", options->parts, "Input files (.t4d), in the order of their times")
      ->required();
  addT4dOutputOption(*command, options->output);
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example, with two processes at work:\n"
      "  t4d sweep bolt.obj --motion screw-in.json --part 1/2 -o first.t4d &\n"
      "  t4d sweep bolt.obj --motion screw-in.json --part 2/2 -o second.t4d; wait\n"
      "  t4d join first.t4d second.t4d -o bolt.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
