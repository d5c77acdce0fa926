#include "convert/slice.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/input_bodies.h"
#include "tools/voxel_series.h"

namespace t4d::tools {
namespace {

struct Options {
  std::string input;
  std::string body;
  VoxelSeriesOptions series;
};

/// The slices of all bodies that exist at a time, together.
Result<model::TriangleMesh> solidAt(const std::vector<convert::Body>& bodies, double time) {
  model::TriangleMesh solid;
  for (const convert::Body& body : bodies) {
    const model::TimeSpan span = model::timeSpanOf(*body.source);
    if (time < span.begin || time > span.end) continue;
    auto slice = convert::sliceAtTime(*body.source, time);
    if (!slice) return pass(slice.error());
    const auto first = static_cast<std::uint32_t>(solid.vertices.size());
    solid.vertices.insert(solid.vertices.end(), slice->mesh.vertices.begin(),
                          slice->mesh.vertices.end());
    for (const auto& [a, b, c] : slice->mesh.triangles) {
      solid.triangles.push_back({first + a, first + b, first + c});
    }
  }
  return solid;
}

int run(const Options& options) {
  auto input = openBodies(options.input, options.body);
  if (!input) return report(input.error());
  return writeVoxelSeries(
      options.series, convert::timeSpanOf(input->bodies),
      [&](double time) { return solidAt(input->bodies, time); }, options.input);
}

}  // namespace

void addRasterize(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("rasterize",
                                     "Write slices of a 4D mesh as a time series of OpenVDB grids");
  auto options = std::make_shared<Options>();
  command->add_option("FILE", options->input, "The .t4d file")->required();
  addBodyOption(*command, options->body);
  options->series.addTo(*command);
  command->footer(
      "Example:\n  t4d rasterize bolt.t4d --voxel-size 0.25 --frames 60 -o bolt-frames");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
