#include "tools/t4d/help_json.h"

#include <sstream>

#include <nlohmann/json.hpp>

#include "tools/t4d/json_option.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

ordered_json namesOf(const std::set<CLI::Option*>& options) {
  auto names = ordered_json::array();
  for (const CLI::Option* option : options) names.push_back(option->get_name());
  return names;
}

/// The words that a value can be, which CLI11 has in the name of its type: "TEXT:{keep,merge}".
ordered_json choicesOf(const std::string& type) {
  auto choices = ordered_json::array();
  const std::size_t begin = type.find('{');
  const std::size_t end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return choices;
  std::istringstream words(type.substr(begin + 1, end - begin - 1));
  for (std::string word; std::getline(words, word, ',');) choices.push_back(word);
  return choices;
}

ordered_json optionJson(const CLI::Option& option) {
  auto names = ordered_json::array();
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  if (option.get_positional()) names.push_back(option.get_name(/*positional=*/true));
  const bool takesValue = option.get_items_expected_max() > 0;
  const std::string type = option.get_type_name();
  return {{"names", names},
          {"about", option.get_description()},
          {"value", takesValue ? ordered_json(type.substr(0, type.find(":{"))) : ordered_json()},
          {"choices", choicesOf(type)},
          {"values", takesValue ? option.get_type_size_max() : 0},
          {"repeats", option.get_expected_max() >= CLI::detail::expected_max_vector_size},
          {"required", option.get_required()},
          {"default", option.get_default_str()},
          {"needs", namesOf(option.get_needs())},
          {"excludes", namesOf(option.get_excludes())}};
}

/// Adds the options, also those of groups, which are commands without a name.
void addOptions(const CLI::App& command, ordered_json& arguments, ordered_json& options) {
  for (const CLI::Option* option : command.get_options()) {
    (option->get_positional() ? arguments : options).push_back(optionJson(*option));
  }
  for (const CLI::App* group : command.get_subcommands(nullptr)) {
    if (group->get_name().empty()) addOptions(*group, arguments, options);
  }
}

}  // namespace

ordered_json helpJson(const CLI::App& command) {
  auto arguments = ordered_json::array();
  auto options = ordered_json::array();
  addOptions(command, arguments, options);
  auto verbs = ordered_json::array();
  for (const CLI::App* verb : command.get_subcommands(nullptr)) {
    if (!verb->get_name().empty()) verbs.push_back(helpJson(*verb));
  }
  return {{"name", command.get_name()},
          {"about", command.get_description()},
          {"arguments", arguments},
          {"options", options},
          {"verbs", verbs},
          {"examples", command.get_footer()},
          {"report", reportSchemaOf(command)}};
}

}  // namespace t4d::tools
