#include "tools/t4d/mend.h"

#include <utility>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/gltf/gltf_writer.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "model/amount_text.h"
#include "platform/kept_inputs.h"
#include "platform/stopwatch.h"
#include "t4d/surface.h"
#include "tools/t4d/bodies_option.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/members.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/solid_input.h"

namespace t4d::tools {
Result<MendReport> mend(const MendOptions& options, Observer& observer) {
  const platform::KeptInputs kept;
  const platform::Stopwatch stopwatch;
  auto loaded = readSolidInput({options.input, options.bodies, options.limits, /*attributes=*/true},
                               observer);
  if (!loaded) return loaded.error();
  MendReport report;
  report.mended = std::move(loaded->mended);
  for (formats::NamedMesh& body : loaded->bodies) {
    body.ownCorners = true;
    report.vertices += body.mesh.vertices.size();
    report.triangles += body.mesh.triangles.size();
  }
  report.losses = std::move(loaded->losses);
  const auto lost = [&] {
    const auto stage = observer.stage("writing " + options.output);
    return formats::writeTriangleMeshes(options.output, loaded->bodies,
                                        {.attributes = true, .materials = loaded->materials});
  }();
  if (!lost) return lost.error();
  report.losses.insert(report.losses.end(), lost->begin(), lost->end());
  const std::string extension = formats::lowerCaseExtension(options.output);
  if (loaded->materials.size() > 1 && !formats::isGltf(options.output) && extension != ".obj") {
    const std::string count = model::counted(loaded->materials.size() - 1, "material");
    report.losses.push_back(fmt::format("the names of {}: {} has none", count, extension));
  }
  report.seconds = stopwatch.seconds();
  return report;
}

void describe(Members& members, const MendReport& report) {
  addMending(members, report.mended);
  members("vertices", report.vertices, "Vertices written.").atLeast(4);
  members("triangles", report.triangles, "Triangles written.").atLeast(4);
  addCosts(members, report.seconds);
}

namespace {

struct MendArguments {
  std::string input;
  std::string output;
  std::string bodies;
  MendingOptions mending;
  bool json = false;
};

void printReport(const MendReport& report, const MendArguments& options) {
  const edit::MendSurfaceReport mended = totalOf(report.mended);
  print("{}: {}, {}, {}{}\n", options.output, counted(report.vertices, "vertex", "vertices"),
        counted(report.triangles, "triangle"), counted(mended.components, "component"),
        options.bodies.empty() ? "" : ", " + counted(report.mended.size(), "body", "bodies"));
  for (const edit::SurfaceChange& change : mended.changes) print("  {}\n", change.text);
  if (mended.changes.empty()) print("  nothing to mend\n");
  for (const auto& [name, body] : report.mended) {
    if (report.mended.size() == 1 || body.changes.empty()) continue;
    print("  body '{}': {}\n", name, measuresOf(body));
  }
  print("  {}{}\n", report.mended.size() == 1 ? "" : "in all: ",
        measuresOf(report.mended.size() == 1 ? report.mended.front().report : mended));
  print("  {:.2f} s, peak memory {}\n", report.seconds, sizeText(peakBytes()));
}

int run(const MendArguments& options) {
  ConsoleObserver observer;
  const auto done = mend(
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
  addJsonOption<MendReport>(*command, options->json,
                            "The changes to a triangle mesh, and the result.");
  command->footer(
      "Example:\n  t4d mend scanned.stl -o solid.ply\n"
      "  t4d mend scanned.stl --max-hole 2 --remesh 0.1 -o solid.ply");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
