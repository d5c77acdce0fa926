#include <algorithm>

#include <fmt/format.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/console_observer.h"
#include "tools/t4d/input_options.h"
#include "tools/t4d/json_option.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/t4d_output.h"
#include "tools/t4d/version.h"
#include "tools/verbs/transform.h"

namespace t4d::tools {
namespace {

struct TransformArguments {
  std::string input;
  InputOptions bodies;
  std::vector<double> scale;
  std::vector<double> rotate;
  std::vector<double> matrix;
  std::vector<double> move;
  std::optional<std::string> space;
  verbs::TransformOptions transform;
  bool json = false;
};

CLI::Validator axesInSomeOrder() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        if (verbs::areAxes(text)) return {};
        return fmt::format(
            "'{}' is not x, y and z in some order, with signs or without, as y-xz, "
            "nor x, y, z and t, as xtzy",
            text);
      },
      "AXES");
}

std::optional<std::string> misuseOf(const TransformArguments& options) {
  if (options.scale.size() == 2) return "--scale is one factor, or three";
  const auto isZero = [](double number) { return number == 0; };
  if (std::ranges::any_of(options.scale, isZero)) return "--scale: 0 leaves no solid";
  const auto& r = options.rotate;
  if (!r.empty() && r[0] == 0 && r[1] == 0 && r[2] == 0) return "--rotate: the axis is 0 0 0";
  if (options.matrix.empty()) return std::nullopt;
  model::Transform matrix;
  matrix.space =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(options.matrix.data());
  if (matrix.flattens()) return "--matrix leaves no solid: its determinant is 0, up to rounding";
  return std::nullopt;
}

verbs::TransformOptions optionsOf(const TransformArguments& arguments) {
  verbs::TransformOptions options = arguments.transform;
  if (const auto& s = arguments.scale; !s.empty()) {
    options.scale = {s.front(), s[s.size() / 2], s.back()};
  }
  if (const auto& r = arguments.rotate; !r.empty()) {
    options.rotate = verbs::Rotation{{r[0], r[1], r[2]}, r[3]};
  }
  if (const auto& m = arguments.matrix; !m.empty()) {
    std::ranges::copy(m, options.matrix.emplace().begin());
  }
  if (const auto& by = arguments.move; !by.empty()) options.move = {by[0], by[1], by[2]};
  if (arguments.space) options.space = *arguments.space == "none" ? "" : *arguments.space;
  options.generator = versionText();
  return options;
}

void printReport(const verbs::TransformReport& done, const std::string& output) {
  print("{}: {}{}\n", output, counted(done.bodies, "body", "bodies"),
        done.map.mirrors() ? ", mirrored" : "");
  print("  {}, {:.2f} s, peak memory {}\n", sizeText(done.bytes), done.seconds,
        sizeText(peakBytes()));
}

int run(const TransformArguments& options) {
  if (const auto misuse = misuseOf(options)) return wrongUsage(*misuse);
  const auto input = verbs::openInput(options.input, options.bodies);
  if (!input) return report(input.error());
  ConsoleObserver observer;
  const auto done = verbs::transform(*input, optionsOf(options), observer);
  if (!done) return report(done.error());
  const std::string& output = options.transform.output;
  if (!done->mirroredSpace.empty()) {
    printNotices(
        {fmt::format("{}: mirrored, and still called {}: left and right are exchanged; "
                     "--space names it anew",
                     output, done->mirroredSpace)});
  }
  if (options.json) {
    printAsJson(*done);
  } else {
    printReport(*done, output);
  }
  return reportLosses(done->losses);
}

}  // namespace

void addTransform(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand(
      "transform", "Move, rotate, scale or mirror a 4D mesh, and change its times");
  auto options = std::make_shared<TransformArguments>();
  command->add_option("FILE", options->input, kT4dFileHelp)->required();
  options->bodies.addTo(*command);
  addT4dOutputOption(*command, options->transform.output);
  command
      ->add_option("--axes", options->transform.axes,
                   "First: axes that become x, y, z, as y-xz, or x, y, z, t, as xtzy or xyz-t")
      ->check(axesInSomeOrder());
  addNumbers(*command, "--scale", options->scale, "Then: scale by one factor, or by one per axis",
             1, 3, "S | SX SY SZ");
  addNumbers(*command, "--rotate", options->rotate,
             "Then: rotate about an axis through the origin, in degrees", 4, 4, "AX AY AZ DEGREES");
  addNumbers(*command, "--matrix", options->matrix,
             "Then: apply a matrix of 3 rows and 4 columns, row by row", 12, 12, "M00 M01 ... M23");
  addNumbers(*command, "--move", options->move, "Then: add to all positions", 3, 3, "DX DY DZ");
  command
      ->add_option("--time-scale", options->transform.timeScale,
                   "Multiply all times by a number above 0")
      ->check(numberAboveZero())
      ->capture_default_str();
  command->add_option("--time-shift", options->transform.timeShift, "Then: add to all times")
      ->check(finiteNumber())
      ->capture_default_str();
  command
      ->add_option("--length-unit", options->transform.lengthUnit,
                   "Set the name of the length unit; coordinates are not converted")
      ->type_name("NAME");
  command
      ->add_option("--time-unit", options->transform.timeUnit,
                   "Set the name of the time unit; times are not converted")
      ->type_name("NAME");
  command
      ->add_option("--up", options->transform.up,
                   "Set the axis that points up; the solid is not rotated")
      ->check(CLI::IsMember({"y", "z"}));
  command->add_option("--space", options->space, "Set the anatomical space; the solid is not moved")
      ->check(CLI::IsMember({"RAS", "LPS", "none"}));
  addCompressionOption(*command, options->transform.compression);
  addJsonOption<verbs::TransformReport>(
      *command, options->json,
      "The map that was applied to a 4D mesh, and the file that was written.");
  command->footer(
      "Example:\n  t4d transform bolt.t4d --rotate 1 0 0 90 --move 0 0 5 -o upright.t4d");
  command->callback([=, &exitCode] { exitCode = run(*options); });
}

}  // namespace t4d::tools
