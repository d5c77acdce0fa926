#include <optional>

#include <fmt/format.h>

#include "formats/triangle/triangle_mesh_formats.h"
#include "tools/t4d/centering.h"
#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/detail_text.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/slice_write_options.h"
#include "tools/verbs/slice.h"

namespace t4d::tools {
namespace {

struct SliceArguments {
  std::string input;
  InputOptions only;
  std::optional<double> x;
  std::optional<double> y;
  std::optional<double> z;
  std::vector<double> hyperplane;
  std::string coplanar = "keep";
  verbs::SliceOptions slice;
  bool json = false;
};

/// The hyperplane given by the options; CLI11 has checked that there is exactly one.
slice::Hyperplane hyperplaneOf(const SliceArguments& options) {
  if (options.slice.time) return slice::Hyperplane::atTime(*options.slice.time);
  if (options.x) return slice::Hyperplane::across(0, *options.x);
  if (options.y) return slice::Hyperplane::across(1, *options.y);
  if (options.z) return slice::Hyperplane::across(2, *options.z);
  const auto& n = options.hyperplane;
  return {{n[0], n[1], n[2], n[3]}, n[4]};
}

/// Why these options cannot be.
std::optional<std::string> misuseOf(const SliceArguments& options) {
  const verbs::SliceOptions& how = options.slice;
  const std::string& color = how.write.color;
  if ((color == "time" || color == "speed" || color == "track") && !how.time) {
    return fmt::format("--color {}: colours are those of a slice at a time (--time)", color);
  }
  if (color == "track" && how.light) return "--color track: not with --light";
  if (auto misuse = misuseOfMaxSpeed(how.write)) return misuse;
  if (const auto checked = slice::checkHyperplane(how.hyperplane); !checked) {
    return "--hyperplane: " + checked.error().message;
  }
  return how.output.empty() ? std::nullopt : misuseOfEncoding(how.write, how.output);
}

void printReport(const SliceArguments& options, const verbs::Input& input,
                 const verbs::SliceReport& made) {
  const verbs::SliceOptions& how = options.slice;
  print("{}{}, {}, {}area {:.12g}\n", how.output.empty() ? "" : how.output + ": ",
        counted(made.vertices, "vertex", "vertices"), counted(made.triangles, "triangle"),
        made.closed ? fmt::format("closed; volume {:.12g}, ", made.volume) : "NOT CLOSED; ",
        made.area);
  print("  read {} of {}, {}{}\n", sizeText(made.bytesRead), sizeText(input.reader->fileBytes()),
        counted(made.slabsRead, "slab"),
        made.requests > 0 ? ", in " + counted(made.requests, "request") : "");
  if (how.light) print("  {}\n", detailText(made.light, made.distance));
  const slice::VelocityReport velocity = made.velocity.value_or(slice::VelocityReport());
  const std::string unit = velocityUnit(input.metadata, /*ofPlayback=*/false);
  printExtra(
      {velocityText(how.write, velocity.maxSpeed, velocity.clamped, unit),
       how.write.velocity
           ? fmt::format("the volume changes by {:.12g} per time unit; velocities are of "
                         "the {}",
                         velocity.volumeRate, velocity.ofPoints ? "points" : "surface")
           : "",
       made.merge ? fmt::format("coplanar triangles merged: {} before; no point moved further "
                                "than {:.3g}",
                                grouped(made.merge->trianglesBefore), made.merge->distance)
                  : "",
       colorText(how.write, made.colorRange), quantizationText(how.write, made.quantizationError)});
}

int run(SliceArguments& options) {
  options.slice.hyperplane = hyperplaneOf(options);
  options.slice.mergeCoplanar = options.coplanar == "merge";
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const auto input = verbs::openInput(options.input, options.only);
  if (!input) return report(input.error());
  ConsoleObserver observer;
  const auto made = verbs::sliceMesh(*input, options.slice, observer);
  if (!made) return report(made.error());
  if (options.json) {
    printAsJson(*made);
  } else {
    printReport(options, *input, *made);
  }
  if (made->triangles == 0) {
    printNotices({"the slice is empty: the solid does not reach this hyperplane"});
  }
  return reportLosses(made->losses, options.slice.write.center);
}

}  // namespace

void addSlice(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("slice", "Cut a 4D mesh at a time or by another hyperplane");
  auto options = std::make_shared<SliceArguments>();
  verbs::SliceOptions& slice = options->slice;
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  auto* cuts = command->add_option_group("hyperplane", "Hyperplane (exactly one)");
  cuts->add_option("-t,--time", slice.time, "Section at time V; coordinates (x, y, z)")
      ->check(finiteNumber());
  cuts->add_option("--x", options->x, "Section at x = V; coordinates (y, z, t)")
      ->check(finiteNumber());
  cuts->add_option("--y", options->y, "Section at y = V; coordinates (x, z, t)")
      ->check(finiteNumber());
  cuts->add_option("--z", options->z, "Section at z = V; coordinates (x, y, t)")
      ->check(finiteNumber());
  addNumbers(*cuts, "--hyperplane", options->hyperplane,
             "Section at A x + B y + C z + D t = OFFSET (coordinates: docs/slice.md)", 5, 5,
             "A,B,C,D,OFFSET");
  cuts->require_option(1);
  command
      ->add_option("-o,--output", slice.output,
                   fmt::format("Output file: {} (default: none, only measure)",
                               formats::writableTriangleMeshExtensions()))
      ->check(someName())
      ->check(writableTriangleMesh());
  options->only.addTo(*command);
  command
      ->add_flag("--light", slice.light,
                 "Interpolate the triangles of the layers: up to 13 times fewer, same volume")
      ->needs("--time");
  command
      ->add_option("--coplanar", options->coplanar,
                   "Keep coplanar triangles, or merge them into fewer")
      ->check(CLI::IsMember({"keep", "merge"}))
      ->capture_default_str();
  addSliceWriteOptions(*command, slice.write);
  command->get_option("--velocity")->needs("--time");
  addCenterOption(*command, slice.write.center);
  addJsonOption<verbs::SliceReport>(
      *command, options->json,
      "The slice of all bodies together. Volume and area are in the units of the slice's three "
      "axes: lengths for a slice at a time; for other slices one axis is time.");
  command->footer("Example:\n  t4d slice bolt.t4d --time 2.5 -o bolt-at-2.5.glb");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
