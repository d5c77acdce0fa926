#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

namespace t4d::tools {

/// The help of a command and of the verbs below it, as JSON (docs/schemas/help.json).
nlohmann::ordered_json helpJson(const CLI::App& command);

}  // namespace t4d::tools
