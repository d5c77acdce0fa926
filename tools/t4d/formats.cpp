#include <array>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/t4d/commands.h"
#include "tools/t4d/console.h"
#include "tools/t4d/file_formats.h"
#include "tools/t4d/json_option.h"

namespace t4d::tools {
namespace {

/// The formats, with the options of those that the user names.
std::vector<FormatsOfKind> formatsWithOptions() {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kOptions = {
      {{".nc", "the option `--gcode`"},
       {".cl", "the option `--locations`"},
       {".tbl", "the option `--tool-table`"}}};
  std::vector<FormatsOfKind> kinds = fileFormats();
  for (auto& [kind, formats] : kinds) {
    for (platform::FileFormat& format : formats) {
      for (const auto& [extension, option] : kOptions) {
        if (format.extensions.front() == extension) format.recognisedBy = option;
      }
    }
  }
  return kinds;
}

int printFormats(bool json) {
  const std::vector<FormatsOfKind> kinds = formatsWithOptions();
  if (json) {
    printAsJson(FileFormats{kinds});
    return kDone;
  }
  for (const auto& [kind, formats] : kinds) {
    std::vector<std::vector<std::string>> rows;
    for (const platform::FileFormat& format : formats) {
      rows.push_back({fmt::format("  {}", format.name),
                      fmt::format("{}", fmt::join(format.extensions, " ")), std::string(format.id),
                      format.reads && format.writes ? "read, written"
                      : format.reads                ? "read"
                                                    : "written"});
    }
    print("{}:\n", kind);
    printTable(rows, "l");
  }
  return kDone;
}

}  // namespace

void addFormats(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("formats", "List the supported file formats");
  auto json = std::make_shared<bool>(false);
  addJsonOption<FileFormats>(*command, *json, "All file formats that are read or written.");
  command->footer("Example:\n  t4d formats");
  command->callback([=, &exitCode] { exitCode = printFormats(*json); });
}

}  // namespace t4d::tools
