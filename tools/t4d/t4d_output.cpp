#include "tools/t4d/t4d_output.h"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/t4d/centering.h"
#include "tools/t4d/input.h"
#include "tools/t4d/option_checks.h"
#include "tools/t4d/version.h"

namespace t4d::tools {

void addT4dOutputOption(CLI::App& command, std::string& path,
                        std::vector<std::string_view> others) {
  const std::string alsoFinal =
      others.empty() ? "" : fmt::format("; or the solid at the end ({})", fmt::join(others, ", "));
  others.insert(others.begin(), ".t4d");
  command
      .add_option("-o,--output", path, "Output file (.t4d), or - for standard output" + alsoFinal)
      ->required()
      ->check(someName())
      ->check(outputFile(std::move(others)));
}

void addCompressionOption(CLI::App& command, int& level) {
  command.add_option("--compression", level, "zstd level, 1 to 19; 0 stores uncompressed")
      ->check(wholeNumber(0, 19))
      ->capture_default_str();
}

void T4dCoding::addTo(CLI::App& command) {
  auto* precisionOption = command.add_option("--precision", precision, "Precision of positions")
                              ->check(CLI::IsMember({"float64", "float32"}))
                              ->capture_default_str();
  command
      .add_option("--grid-step", grid,
                  "Round positions to multiples of STEP (error per axis up to STEP / 2)")
      ->type_name("STEP")
      ->check(numberAboveZero())
      ->excludes(precisionOption);
  addCompressionOption(command, compression);
  command
      .add_option("--spare-copies", spareEvery,
                  "Repeat shared data every N slabs (at least 2), for recovery; 0: store once")
      ->type_name("N")
      ->check(wholeNumber(0, 1'000'000))
      ->check(noLoneCopy())
      ->capture_default_str();
}

formats::T4dWriteOptions T4dCoding::writeOptions() const {
  return {.compression = compression,
          .float32 = precision == "float32",
          .step = grid,
          .spareEvery = spareEvery};
}

std::optional<std::string> T4dCoding::rounding() const {
  if (!grid) return std::nullopt;
  return fmt::format("positions on a grid of {}: at most {} off along each axis; poses are exact",
                     *grid, *grid / 2);
}

void T4dOutput::addTo(CLI::App& command, std::vector<std::string_view> others) {
  addT4dOutputOption(command, path, std::move(others));
  coding.addTo(command);
  command
      .add_option("--up", up, "Axis that points up (default: y, or z if the input is RAS or LPS)")
      ->check(CLI::IsMember({"y", "z"}));
  addCenterOption(command, center);
  command.add_option("--body", body, "Name of the body (default: name of the input file)")
      ->check(someName());
}

T4dFileOptions T4dOutput::fileOptions() const {
  return {path, coding.writeOptions(), up, body, center, std::string(versionText())};
}

}  // namespace t4d::tools
