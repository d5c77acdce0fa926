#include "tools/t4d/json_option.h"

#include <map>
#include <utility>

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

struct Described {
  std::string about;
  JsonSchema schema;
};

std::map<const CLI::App*, Described>& reports() {
  static std::map<const CLI::App*, Described> all;
  return all;
}

/// The words of a verb, from that of the program.
std::string wordsOf(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return parent == nullptr ? "t4d" : wordsOf(*parent) + " " + command.get_name();
}

}  // namespace

CLI::Option* addJsonOption(CLI::App& command, bool& json, const std::string& about,
                           JsonSchema schema) {
  reports()[&command] = {about, std::move(schema)};
  return command.add_flag("--json", json, "Print JSON");
}

ordered_json reportSchemaOf(const CLI::App& command) {
  const auto found = reports().find(&command);
  if (found == reports().end()) return nullptr;
  ordered_json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                         {"title", wordsOf(command) + " --json"},
                         {"description", found->second.about}};
  schema.update(found->second.schema());
  if (command.get_option_no_throw("--most-parts") != nullptr) {
    schema["properties"]["part"] = {
        {"type", "object"},
        {"description",
         "With --part K/N: which part of which run this is, and what t4d join needs to know of it "
         "(docs/join.md)."}};
  }
  return schema;
}

}  // namespace t4d::tools
