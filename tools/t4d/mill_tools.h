#pragma once

#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "formats/toolpath/tool_table.h"
#include "tools/verbs/mill_tools.h"

namespace t4d::tools {

/// `--tool`, `--shank` and `--holder`: sizes or a file, of one tool or as N=SPEC of tool N.
struct MillToolOptions {
  std::vector<std::string> tools;
  std::vector<std::string> shanks;
  std::vector<std::string> holders;

  void addTo(CLI::App& command);
};

/// What is said of the tools, by options and by the remarks of a tool table. Fails, with a sentence
/// about the options, for what cannot be.
Result<verbs::MillToolSpecs> millToolSpecs(const MillToolOptions& options,
                                           const std::map<int, formats::TableTool>& table);

}  // namespace t4d::tools
