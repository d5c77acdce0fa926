#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/toolpath/gcode_block.h"
#include "formats/toolpath/gcode_parameters.h"
#include "formats/toolpath/gcode_words.h"
#include "t4d/error.h"

namespace t4d::formats {

/// The lines of a program and the order in which they come: O-words of LinuxCNC (sub, call, return,
/// if, while, do, repeat, break, continue); of Fanuc's controls M98 P L, G65 P L and M99 with
/// subprograms that begin with a line O100, WHILE [..] DO 1, END 1, IF [..] GOTO 10, IF [..] THEN,
/// GOTO 10; and M97 P10 of Haas', which calls the lines from N10.
class GcodeProgram {
 public:
  static constexpr std::size_t kDeepestCall = 100;

  /// Of a line, and how deep in calls it is.
  using Apply =
      std::function<Result<void>(const GcodeBlock& block, std::uint64_t line, std::size_t depth)>;

  /// The text, the parameters and what `apply` uses must outlive this.
  GcodeProgram(std::string_view text, GcodeDialect dialect, GcodeParameters& parameters,
               Apply apply);

  /// Has the blocks of lines applied in the order of the program. Errors have no place, which is
  /// line().
  /// Fails if it carries out `repeatedLines` more lines than it has: it may never end.
  Result<void> run(std::uint64_t repeatedLines);

  std::uint64_t line() const { return at_ + 1; }
  std::size_t optionalLines() const { return optionalLines_; }  ///< with /, carried out
  /// Whether M99 ended the main program, which a machine would repeat for ever.
  bool repeatsForEver() const { return repeatsForEver_; }

 private:
  enum class Flow : std::uint8_t {
    Name,  // O100 alone
    Sub,
    EndSub,
    Call,
    Return,
    Do,
    WhileOfDo,
    While,
    EndWhile,
    If,
    ElseIf,
    Else,
    EndIf,
    Break,
    Continue,
    Repeat,
    EndRepeat,
    IfThen,  // IF [..] GOTO, IF [..] THEN
    GoTo
  };
  struct OWord {
    Flow flow = Flow::Name;
    std::string label;
    std::string rest;                   // of the line
    std::size_t other = 0;              // line of the other end; of branches and jumps, the begin
    std::vector<std::size_t> branches;  // of If: lines of the others, and of the end
  };
  struct Called {
    std::size_t from = 0;                        // line
    std::size_t begin = 0;                       // line of the subprogram
    double left = 0;                             // how often M98 repeats it
    bool isMacro = false;                        // G65, with arguments of its own
    std::map<std::size_t, double> repeats = {};  // left of the loops in it, by line
  };

  Result<void> findOWords();
  Result<void> readLine(std::size_t& part);
  static Result<OWord> oWordOf(std::string_view text);
  static std::optional<OWord> macroOf(std::string_view text);
  Result<void> join(OWord& word);
  Result<void> joinJump(OWord& word);
  Result<void> joinEnd(OWord& word);
  Result<void> define(std::map<std::string, std::size_t>& names, const OWord& word);

  Result<void> runLine();
  Result<void> runBlock(std::string_view text);
  Result<void> follow(const OWord& word);
  Result<void> chooseBranch(const OWord& begin);
  Result<void> beginRepeats(const OWord& word);
  void endRepeat(const OWord& word);
  Result<double> conditionOf(const OWord& word);
  Result<void> call(const OWord& word);
  Result<void> leave(const OWord& word);
  Result<void> ifThen(std::string_view text);
  Result<void> goTo(GcodeWords& words);
  Result<void> enter(std::size_t begin, double times);
  Result<std::pair<std::size_t, double>> numberedSub(const GcodeBlock& block) const;
  Result<void> callNumbered(const GcodeBlock& block);
  Result<void> leaveNumbered();

  std::vector<std::string_view> lines_;
  GcodeDialect dialect_;
  GcodeParameters& parameters_;
  Apply apply_;
  std::map<std::size_t, OWord> oWords_;       // by line
  std::vector<std::size_t> open_;             // lines of blocks, while O-words are looked for
  std::map<std::string, std::size_t> subs_;   // lines, by label
  std::map<std::string, std::size_t> names_;  // of O100 alone
  std::map<std::size_t, std::size_t> ends_;   // of these that M99 ends: the line of the last one
  std::map<std::string, std::vector<std::size_t>> numbers_;  // lines, by N
  std::size_t at_ = 0;                                       // line, from 0
  std::size_t next_ = 0;
  std::vector<Called> calls_;  // the first one is the main program
  bool begun_ = false;         // by %
  bool ended_ = false;
  std::size_t optionalLines_ = 0;
  bool repeatsForEver_ = false;
};

}  // namespace t4d::formats
