#pragma once

#include <CLI/CLI.hpp>

/// The verbs of the program. Each adds its subcommand to the application; when it is chosen, its
/// callback runs it and sets the exit code.
namespace t4d::tools {

/// addSweep, addSlice, ...: one for each line of the table of verbs in CMakeLists.txt.
#define T4D_VERB(Name) void add##Name(CLI::App& app, int& exitCode);
#include "tools/program/verbs.inc"
#undef T4D_VERB

/// Adds all verbs in the order of the table.
void addVerbs(CLI::App& app, int& exitCode);

/// What is wrong with the verb `word` of `command` ("" where it is missing), with the verbs that
/// there are.
std::string wrongVerb(const CLI::App& command, const std::string& word);

/// Verbs of `conform`.
void addConformBackends(CLI::App& conform, int& exitCode);
void addConformReader(CLI::App& conform, int& exitCode);
void addConformCorpus(CLI::App& conform, int& exitCode);

}  // namespace t4d::tools
