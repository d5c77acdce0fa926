#pragma once

#include <CLI/CLI.hpp>

/// The verbs of the program. Each function adds a subcommand to the application; its callback runs
/// the verb and sets the exit code.
namespace t4d::tools {

/// addSweep, addSlice, ...: one for each line of the table of verbs in CMakeLists.txt.
#define T4D_VERB(Name) void add##Name(CLI::App& app, int& exitCode);
#include "tools/t4d/verbs.inc"
#undef T4D_VERB

/// Adds all verbs in the order of the table.
void addVerbs(CLI::App& app, int& exitCode);

/// The error message for an unknown verb `word` of `command` ("" if it is missing), with a list of
/// the existing verbs.
std::string wrongVerb(const CLI::App& command, const std::string& word);

/// Verbs of `conform`.
void addConformBackends(CLI::App& conform, int& exitCode);
void addConformReader(CLI::App& conform, int& exitCode);
void addConformWriter(CLI::App& conform, int& exitCode);
void addConformCorpus(CLI::App& conform, int& exitCode);

}  // namespace t4d::tools
