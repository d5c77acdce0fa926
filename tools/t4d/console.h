#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json_fwd.hpp>

#include "model/amount_text.h"
#include "t4d/error.h"
#include "tools/t4d/progress_bar.h"

/// Output of the program. Results go to standard output, everything else to standard error.
namespace t4d::tools {

/// Exit codes, the same for every verb.
enum ExitCode : int {
  kDone = 0,
  kFailed = 1,  ///< also: a file cannot be written
  kUsage = 2,
  kLoss = 3,     ///< done, but something was lost and has been reported
  kInvalid = 4,  ///< the input is invalid or cannot be read
};

/// The text with control characters, those that change the direction of writing, and bytes that are
/// not UTF-8 as "\\x1b" and the like, but for line breaks: names in a file must not command the
/// terminal.
std::string shown(std::string_view text);

/// The text of a name or a sentence, whose line breaks would begin a line of their own: "\\n".
std::string shownLine(std::string_view text);

/// Turns off progress and notices and, with `results`, what `print` and `printTable` print. Errors,
/// losses and JSON are still printed.
void beQuiet(bool results);
/// Turns off what `print` and `printTable` print, alone.
void hideResults();

/// Prints to standard output; a failure is kept for printError.
void printText(std::string_view text);

/// Prints a result to standard output, as `shown`.
void printResult(const std::string& text);

/// A value for `print`: texts as `shownLine`.
template <class Value>
decltype(auto) printable(const Value& value) {
  if constexpr (std::is_convertible_v<const Value&, std::string_view>) {
    return shownLine(value);
  } else {
    return (value);
  }
}
template <class... Values>
void printValues(fmt::string_view text, const Values&... values) {
  printResult(fmt::vformat(text, fmt::make_format_args(values...)));
}

/// Prints a result to standard output. Line breaks are those of `text`, not of the values.
template <class... Values>
void print(fmt::format_string<Values...> text, Values&&... values) {
  printValues(text, printable(values)...);
}

/// Prints those of these lines that are not empty, indented as the lines under a result.
void printExtra(const std::vector<std::string>& lines);

/// Why something could not be printed to standard output so far, as an errno; 0 if all was.
int printError();

/// Prints "t4d: ", the message as `shownLine` and a line break to standard error; ignores failures.
/// Shortens a message that repeats pages of its input.
void say(const std::string& message);

/// Prints the text to standard error as `shown`, without "t4d: " and a line break.
void sayAsIs(const std::string& text);

/// Prints what is wrong with the options and returns kUsage.
int wrongUsage(const std::string& message);

/// Prints the error and, if there is one, a hint (hints.h). Returns the exit code for it.
int report(const Error& error);

/// Prints a hint unless it is empty.
void sayHint(const std::string& hint);

/// Prints each notice as a "note: " line.
void printNotices(const std::vector<std::string>& notices);

/// Prints each loss as a "lost: " line. Returns kLoss if there are any, kDone otherwise.
int reportLosses(const std::vector<std::string>& losses);

void printJson(const nlohmann::ordered_json& value);

/// Prints rows of cells in aligned columns. `alignment` has one letter per column, l or r; the last
/// applies to all further columns.
void printTable(const std::vector<std::vector<std::string>>& rows, std::string_view alignment);

using model::counted;
using model::grouped;
using model::sizeText;

/// Peak memory of the process or, if that is more, of one that it ran, in bytes.
std::uint64_t peakBytes();

}  // namespace t4d::tools
