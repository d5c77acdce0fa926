#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "formats/toolpath/tool_table.h"
#include "mill/mill.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {
/// A tool: sizes as mill::parseTool takes them, or the file of a triangle mesh; and what holds it:
/// sizes as mill::parseCylinder takes them, a file, or "" for nothing.
struct MillToolSpec {
  std::string tool;
  std::string shank = {};
  std::string holder = {};

  /// Those of the three that are files.
  std::vector<std::string> files() const;
};

/// By number: 0, alone, if they have none.
using MillToolSpecs = std::map<int, MillToolSpec>;

/// Whether sizes are given and not a file.
bool isToolShape(const std::string& text);
bool isCylinderShape(const std::string& text);

/// Adds the tools of which the remark in the table begins with sizes, unless tools have no numbers.
void addToolsOfTable(const std::map<int, formats::TableTool>& table, MillToolSpecs& specs);

/// Meshes of the tools, round ones within `tolerance` (length units); the observer gets the notices
/// of files, `losses` what is lost of them. Fails for sizes that cannot be parsed, and for files
/// that cannot be read.
Result<std::vector<mill::Tool>> readMillTools(const MillToolSpecs& specs, double tolerance,
                                              std::vector<std::string>& losses,
                                              Observer& observer = nobody());

/// What a name of mill::partOfTool() was given as; nothing of another name.
std::optional<std::string> givenAs(std::string_view part, const MillToolSpecs& specs);

/// `--tool`, `--shank` and `--holder`: sizes or a file, of one tool or as N=SPEC of tool N.
struct MillToolOptions {
  std::vector<std::string> tools;
  std::vector<std::string> shanks;
  std::vector<std::string> holders;

  void addTo(CLI::App& command);
};

/// What is said of the tools, by options and by the remarks of a tool table. Fails, with a sentence
/// about the options, for what cannot be.
Result<MillToolSpecs> millToolSpecs(const MillToolOptions& options,
                                    const std::map<int, formats::TableTool>& table);

}  // namespace t4d::tools
