
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/system/stopwatch.h"
#include "t4d/verbs/mending.h"
#include "t4d/verbs/solid_input.h"
#include "tools/program/bodies_option.h"
#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/console_observer.h"
#include "tools/program/mending.h"
#include "tools/program/option_checks.h"

namespace t4d::tools {
namespace {

struct MendArguments {
  std::string input;
  std::string output;
  std::string bodies;
  MendingOptions mending;
  bool json = false;
};

int run(const MendArguments& options) {
  if (const auto misuse = misuseOfOutput(options.output, {&options.input, 1})) {
    return wrongUsage(*misuse);
  }
  const system::Stopwatch stopwatch;
  ConsoleObserver observer;
  auto loaded = verbs::readSolidInput(
      {options.input, bodiesBy(options.bodies), options.mending.limits}, observer);
  if (!loaded) return report(loaded.error());
  if (const auto misuse = misuseOfOutput(options.output, loaded->otherFiles)) {
    return wrongUsage(*misuse);
  }
  const edit::MendSurfaceReport& mended = *loaded->mended;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  for (const formats::NamedMesh& body : loaded->bodies) {
    vertices += body.mesh.vertices.size();
    triangles += body.mesh.triangles.size();
  }
  auto lost = [&] {
    const ProgressBar bar("writing " + options.output);
    return formats::writeTriangleMeshes(options.output, loaded->bodies);
  }();
  if (!lost) return report(lost.error());

  const double seconds = stopwatch.seconds();
  if (options.json) {
    auto result = verbs::mendJson(mended);
    result["vertices"] = vertices;
    result["triangles"] = triangles;
    result["seconds"] = seconds;
    result["peak_bytes"] = peakBytes();
    printJson(result);
  } else {
    print("{}: {}, {}, {}{}\n", options.output, counted(vertices, "vertex", "vertices"),
          counted(triangles, "triangle"), counted(mended.components, "component"),
          options.bodies.empty() ? "" : ", " + counted(loaded->bodies.size(), "body", "bodies"));
    for (const edit::SurfaceChange& change : mended.changes) print("  {}\n", change.text);
    if (mended.changes.empty()) print("  nothing to mend\n");
    print("  {}\n", verbs::measuresOf(mended));
    print("  {:.2f} s, peak memory {}\n", seconds, sizeText(peakBytes()));
  }
  std::vector<std::string> losses = std::move(loaded->losses);
  losses.insert(losses.end(), lost->begin(), lost->end());
  return reportLosses(losses);
}

}  // namespace

void addMend(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("mend",
                                     "Make a triangle mesh closed, manifold and free of "
                                     "self-intersections");
  auto options = std::make_shared<MendArguments>();
  command
      ->add_option("MODEL", options->input,
                   "Input mesh: " + formats::readableTriangleMeshExtensions())
      ->required();
  command
      ->add_option("-o,--output", options->output,
                   "Output file: " + formats::writableTriangleMeshExtensions())
      ->required()
      ->check(someName())
      ->check(writableTriangleMesh());
  addBodiesOption(*command, options->bodies);
  options->mending.addTo(*command);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Example:\n  t4d mend scanned.stl -o solid.ply\n"
      "  t4d mend scanned.stl --max-hole 2 --remesh 0.1 -o solid.ply");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
