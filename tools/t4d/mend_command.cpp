#include <fmt/format.h>

#include "formats/triangle/triangle_mesh_formats.h"
#include "tools/t4d/bodies_option.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/option_checks.h"
#include "tools/verbs/mend.h"
#include "tools/verbs/mending.h"

namespace t4d::tools {
namespace {

struct MendArguments {
  std::string input;
  std::string output;
  std::string bodies;
  MendingOptions mending;
  bool json = false;
};

void printReport(const verbs::MendReport& report, const MendArguments& options) {
  const edit::MendSurfaceReport mended = verbs::totalOf(report.mended);
  print("{}: {}, {}, {}{}\n", options.output, counted(report.vertices, "vertex", "vertices"),
        counted(report.triangles, "triangle"), counted(mended.components, "component"),
        options.bodies.empty() ? "" : ", " + counted(report.mended.size(), "body", "bodies"));
  for (const edit::SurfaceChange& change : mended.changes) print("  {}\n", change.text);
  if (mended.changes.empty()) print("  nothing to mend\n");
  for (const auto& [name, body] : report.mended) {
    if (report.mended.size() == 1 || body.changes.empty()) continue;
    print("  body '{}': {}\n", name, verbs::measuresOf(body));
  }
  print("  {}{}\n", report.mended.size() == 1 ? "" : "in all: ",
        verbs::measuresOf(report.mended.size() == 1 ? report.mended.front().report : mended));
  print("  {:.2f} s, peak memory {}\n", report.seconds, sizeText(peakBytes()));
}

int run(const MendArguments& options) {
  ConsoleObserver observer;
  const auto done = verbs::mend(
      {options.input, bodiesBy(options.bodies), options.mending.limits, options.output}, observer);
  if (!done) return report(done.error());
  if (options.json) {
    printAsJson(*done);
  } else {
    printReport(*done, options);
  }
  return reportLosses(done->losses);
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
  addJsonOption<verbs::MendReport>(*command, options->json,
                                   "The changes to a triangle mesh, and the result.");
  command->footer(
      "Example:\n  t4d mend scanned.stl -o solid.ply\n"
      "  t4d mend scanned.stl --max-hole 2 --remesh 0.1 -o solid.ply");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
