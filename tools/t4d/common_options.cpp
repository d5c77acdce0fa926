#include "tools/t4d/common_options.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/parallel.h"
#include "tools/t4d/console.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

struct CommonOptions {
  std::optional<std::size_t> threads;
  bool quiet = false;
  std::optional<model::ThreadLimit> limit;
};

/// What the verb writes, so that what is printed about it is not the result; "" for nothing.
std::string writtenBy(const CLI::App& command) {
  for (const char* name : {"--output", "OUT"}) {
    const CLI::Option* output = command.get_option_no_throw(name);
    if (output != nullptr && output->count() > 0) return output->results().front();
  }
  return {};
}

bool hasJson(const CLI::App& command) {
  const CLI::Option* json = command.get_option_no_throw("--json");
  return json != nullptr && json->count() > 0;
}

}  // namespace

void addCommonOptions(CLI::App& command) {
  // Groups of options are subcommands without a name.
  auto below = command.get_subcommands(nullptr);
  std::erase_if(below, [](const CLI::App* verb) { return verb->get_name().empty(); });
  for (CLI::App* verb : below) addCommonOptions(*verb);
  if (!below.empty()) return;
  auto options = std::make_shared<CommonOptions>();
  command
      .add_option("--threads", options->threads,
                  "Maximum number of threads (default: one per processor)")
      ->type_name("N")
      ->check(wholeNumber(1, 1024));
  command.add_flag("-q,--quiet", options->quiet,
                   "Suppress progress, notes and the summary of the output");
  command.parse_complete_callback([options, &command] {
    if (options->threads) {
      options->limit.emplace(*options->threads);
    }
    const std::string written = writtenBy(command);
    if (written == "-" && hasJson(command)) {
      throw CLI::ValidationError("--json", "the file goes to the standard output; name a file");
    }
    if (written == "-") hideResults();
    if (options->quiet) beQuiet(!written.empty());
  });
}

}  // namespace t4d::tools
