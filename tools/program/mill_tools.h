#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/formats/toolpath/tool_table.h"
#include "t4d/mill/mill.h"

namespace t4d::tools {

/// `--tool`, `--shank` and `--holder`: sizes or a file, of one tool or as N=SPEC of tool N.
struct MillToolOptions {
  std::vector<std::string> tools;
  std::vector<std::string> shanks;
  std::vector<std::string> holders;

  void addTo(CLI::App& command);
};

/// What is said of a tool: sizes or a file, "" for no shank or holder.
struct MillToolSpec {
  std::string tool;
  std::string shank;
  std::string holder;

  std::vector<std::string> files() const;
};

/// By number: 0, alone, if they have none.
using MillToolSpecs = std::map<int, MillToolSpec>;

/// What is said of the tools, by options and by the remarks of a tool table. Fails, with a sentence
/// about the options, for what cannot be.
Result<MillToolSpecs> millToolSpecs(const MillToolOptions& options,
                                    const std::map<int, formats::TableTool>& table);

Result<std::vector<mill::Tool>> readMillTools(const MillToolSpecs& specs, double tolerance,
                                              std::vector<std::string>& losses);

/// What a name of mill::partOfTool() was given as; nothing of another name.
std::optional<std::string> givenAs(const std::string& part, const MillToolSpecs& specs);

}  // namespace t4d::tools
