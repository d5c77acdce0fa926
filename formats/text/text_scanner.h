#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "formats/input_file.h"
#include "t4d/error.h"

namespace t4d::formats {

/// Lexical rules of a text.
struct TextRules {
  char comment = '\0';        ///< starts a comment that ends with the line; '\0': there are none
  bool continuation = false;  ///< a backslash at the end of a line continues it on the next
};

/// Reads a text line by line and word by word, and keeps the line number for errors. Lines end with
/// \n, \r\n or \r. Words are separated by blanks. The file must outlive the scanner.
class TextScanner {
 public:
  explicit TextScanner(const InputFile& file, TextRules rules = {});

  /// Goes to the next line that holds a word; false at the end of the text.
  bool nextLine();

  /// The next word of this line; empty when there is none.
  std::string_view word();

  /// The next word of this line or of the lines after it; empty at the end of the text.
  std::string_view wordAcrossLines();

  /// The rest of this line, without the blanks around it; ends the line.
  std::string_view rest();

  /// Skips the line break here, after which binary data follow; returns the offset behind it.
  std::size_t skipLineBreak();

  /// Reads the next word of this line as a number: the nearest double, or the exact integer.
  /// Returns false on failure; `error()` then says what was found and that `what` was expected.
  bool number(double& value, const char* what);
  bool integer(std::int64_t& value, const char* what);

  /// Parse a word that has been read, with the errors of `number` and `integer`.
  bool parse(std::string_view word, double& value, const char* what);
  bool parse(std::string_view word, std::int64_t& value, const char* what);
  bool parse(std::string_view word, std::uint64_t& value, const char* what);

  /// True when the line holds another word.
  bool hasWord();

  std::uint64_t line() const { return line_; }
  std::size_t bytesLeft() const { return text_.size() - at_; }
  Place where() const { return file_.atLine(line_); }
  const Error& error() const { return error_; }

  /// An InvalidInput error at the present line.
  Error invalidHere(std::string message) const { return invalid(std::move(message), where()); }
  /// "found 'WORD', expected WHAT"; an empty word means that the line ends.
  Error unexpectedWord(std::string_view word, std::string_view what) const;

 private:
  std::size_t lineBreakAt(std::size_t at) const;
  void skipBlanks();
  bool fails(std::string_view word, const char* what);

  const InputFile& file_;
  std::string_view text_;
  TextRules rules_;
  std::size_t at_ = 0;
  bool started_ = false;
  std::uint64_t line_ = 1;
  Error error_;
};

/// A word in quotes for a message: shortened, and without control characters.
std::string inQuotes(std::string_view word);

}  // namespace t4d::formats
