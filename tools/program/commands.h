#pragma once

#include <CLI/CLI.hpp>

/// The verbs of the program. Each adds its subcommand to the application; when it is chosen, its
/// callback runs it and leaves the exit code.
namespace t4d::tools {

void addSweep(CLI::App& app, int& exitCode);
void addSlice(CLI::App& app, int& exitCode);
void addFlipbook(CLI::App& app, int& exitCode);
void addInfo(CLI::App& app, int& exitCode);
void addValidate(CLI::App& app, int& exitCode);
void addRecover(CLI::App& app, int& exitCode);
void addCompare(CLI::App& app, int& exitCode);
void addConform(CLI::App& app, int& exitCode);
/// Verbs of `conform`.
void addConformBackends(CLI::App& conform, int& exitCode);
void addConformReader(CLI::App& conform, int& exitCode);
void addConformCorpus(CLI::App& conform, int& exitCode);
void addVersion(CLI::App& app, int& exitCode);
void addWeave(CLI::App& app, int& exitCode);
void addVoxelize(CLI::App& app, int& exitCode);
void addRasterize(CLI::App& app, int& exitCode);

}  // namespace t4d::tools
