#include "formats/toolpath/gcode_reader.h"

#include <fmt/format.h>

#include "formats/toolpath/gcode_dialect.h"
#include "formats/toolpath/gcode_machine.h"
#include "formats/toolpath/gcode_parameters.h"
#include "formats/toolpath/gcode_program.h"

namespace t4d::formats {

Result<ToolPath> readGcode(const InputFile& file, const ToolPathOptions& options) {
  const GcodeHabits habits = habitsOf(file.bytes, options.dialect);
  GcodeMachine machine(options, habits);
  GcodeParameters parameters({[&](int number) { return machine.parameter(number); },
                              [&](const std::string& name) { return machine.parameter(name); }});
  GcodeProgram program(file.bytes, habits.dialect, parameters,
                       [&](const GcodeBlock& block, std::uint64_t line, std::size_t depth) {
                         return machine.apply(block, line, depth);
                       });
  if (auto ran = program.run(options.repeatedLines); !ran) {
    Error error = ran.error();
    error.where = file.atLine(program.line());
    return error;
  }
  auto path = machine.finish(file);
  if (!path) {
    if (path.error().where.empty()) path.error().where = file.path.string();
    return path;
  }
  if (program.repeatsForEver()) {
    path->notices.push_back(file.path.string() +
                            ": M99 repeats the program for ever; it is carried out once");
  }
  const std::size_t optional = program.optionalLines();
  if (optional > 0) {
    path->notices.push_back(
        fmt::format("{}: {} with / (block delete) {} carried out", file.path.string(),
                    optional == 1 ? "1 line" : fmt::format("{} lines", optional),
                    optional == 1 ? "is" : "are"));
  }
  return path;
}

Result<ToolPath> readGcode(const std::filesystem::path& path, const ToolPathOptions& options) {
  const auto file = readInputFile(path);
  if (!file) return file.error();
  return readGcode(*file, options);
}

}  // namespace t4d::formats
