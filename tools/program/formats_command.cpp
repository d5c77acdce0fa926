#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "tools/program/commands.h"
#include "tools/program/console.h"
#include "tools/program/format_list.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

int printFormats(bool json) {
  const std::vector<ListedFormat> list = formatList();
  if (json) {
    ordered_json rows = ordered_json::array();
    for (const ListedFormat& format : list) {
      rows.push_back({{"name", format.name},
                      {"id", format.id},
                      {"extensions", format.extensions},
                      {"kind", format.kind},
                      {"reads", format.reads},
                      {"writes", format.writes},
                      {"recognised_by", format.recognisedBy},
                      {"keeps", format.keeps}});
    }
    printJson({{"formats", rows}});
    return kDone;
  }
  std::string kind;
  std::vector<std::vector<std::string>> rows;
  const auto flush = [&] {
    if (rows.empty()) return;
    print("{}:\n", kind);
    printTable(rows, "l");
    rows.clear();
  };
  for (const ListedFormat& format : list) {
    if (format.kind != kind) flush();
    kind = format.kind;
    rows.push_back({"  " + format.name, fmt::format("{}", fmt::join(format.extensions, " ")),
                    format.id,
                    format.reads && format.writes ? "read, written"
                    : format.reads                ? "read"
                                                  : "written"});
  }
  flush();
  return kDone;
}

}  // namespace

void addFormats(CLI::App& app, int& exitCode) {
  auto* command = app.add_subcommand("formats", "List the supported file formats");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print JSON, with what each format keeps");
  command->footer("Example:\n  t4d formats");
  command->callback([=, &exitCode] { exitCode = printFormats(*json); });
}

}  // namespace t4d::tools
