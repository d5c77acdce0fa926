#include "tools/program/t4d_output.h"

#include "tools/program/option_checks.h"
#include "tools/program/version.h"

namespace t4d::tools {

std::filesystem::path nameIn(const std::string& path) {
  std::error_code error;
  const auto whole = std::filesystem::absolute(path, error).lexically_normal();
  return whole.has_filename() ? whole.filename() : whole.parent_path().filename();
}

void T4dOutput::addTo(CLI::App& command) {
  command.add_option("-o,--output", path, "The .t4d file to write")
      ->required()
      ->check(someName())
      ->check(noOtherFormat());
  command.add_option("--precision", precision, "Type of the positions: float64 or float32")
      ->check(CLI::IsMember({"float64", "float32"}))
      ->capture_default_str();
  command
      .add_option("--compression", compression, "zstd level from 1 to 19; 0 turns compression off")
      ->check(wholeNumber(0, 19))
      ->capture_default_str();
  command.add_option("--up", up, "Axis that points up in glTF: y or z")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  command.add_option("--body", body, "Name of the body (default: that of the input file)");
}

Result<formats::T4dWriter> T4dOutput::create(const std::string& backend, const std::string& model,
                                             const std::string& lengthUnit,
                                             const std::string& timeUnit,
                                             const std::string& detailsJson) const {
  formats::Metadata metadata;
  metadata.generator = std::string(versionText());
  metadata.backend = backend;
  metadata.lengthUnit = lengthUnit;
  metadata.timeUnit = timeUnit;
  metadata.up = up;
  metadata.bodies = {body.empty() ? nameIn(model).stem().string() : body};
  metadata.detailsJson = detailsJson;
  return formats::T4dWriter::create(
      path, metadata, {.compression = compression, .float32 = precision == "float32"});
}

}  // namespace t4d::tools
