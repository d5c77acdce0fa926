#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "t4d/model/error.h"
#include "tools/program/progress_bar.h"

/// What the program says, and where: results on standard output, all else on standard error.
namespace t4d::tools {

/// Exit codes, the same for every verb.
enum ExitCode : int {
  kDone = 0,
  kFailed = 1,  ///< also: a file cannot be written
  kUsage = 2,
  kLoss = 3,     ///< done, but something was lost; it has been listed
  kInvalid = 4,  ///< the input is invalid or cannot be read
};

/// Prints "t4d: ", the message and a line's end on standard error. Where that takes nothing, the
/// message is lost.
void say(const std::string& message);

/// Says that options have no sense and returns kUsage.
int wrongUsage(const std::string& message);

/// Prints the error, with the command to try next where there is one, and returns the exit code
/// that goes with it.
int report(const Error& error);

/// Prints the command to try next, unless it is empty.
void suggest(const std::string& command);

/// Prints a sentence for each thing that a user should know.
void printNotices(const std::vector<std::string>& notices);

/// Prints what was lost; returns kLoss if there is anything, kDone otherwise.
int reportLosses(const std::vector<std::string>& losses);

void printJson(const nlohmann::ordered_json& value);

/// Prints rows of cells in columns that are flush left or right, as `alignment` has a letter, l or
/// r, for each; the last is for all others too.
void printTable(const std::vector<std::vector<std::string>>& rows, std::string_view alignment);

/// "1,234,567".
std::string grouped(std::uint64_t number);

/// "1 slab", "2,000 slabs"; `many` where the plural is not `one` with an s.
std::string counted(std::uint64_t number, std::string_view one, std::string_view many = {});

/// "12.3 MB".
std::string sizeText(std::uint64_t bytes);

/// The largest memory the process has had, in bytes.
std::uint64_t peakBytes();

}  // namespace t4d::tools
