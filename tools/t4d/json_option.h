#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "tools/t4d/console.h"
#include "tools/t4d/members.h"

/// The option --json, and the JSON Schemas of what it prints.
namespace t4d::tools {

using JsonSchema = std::function<nlohmann::ordered_json()>;

/// Adds --json to a verb, and the schema of its report to what `--help --json` says of the verb;
/// `about` is the description of the report.
CLI::Option* addJsonOption(CLI::App& command, bool& json, const std::string& about,
                           JsonSchema schema);

/// The same for a report that describes itself.
template <IsDescribed Report>
CLI::Option* addJsonOption(CLI::App& command, bool& json, const std::string& about) {
  return addJsonOption(command, json, about, [] { return Members::schemaOf<Report>(); });
}

/// The schema of the report of a verb; null if it has none.
nlohmann::ordered_json reportSchemaOf(const CLI::App& command);

/// Prints a report as JSON.
template <IsDescribed Report>
void printAsJson(const Report& report) {
  printText(reportText(report) + "\n");
}

}  // namespace t4d::tools
