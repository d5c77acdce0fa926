#pragma once

#include <string>
#include <string_view>

#include "formats/toolpath/gcode_parameters.h"
#include "t4d/error.h"

namespace t4d::formats {

/// A line of G-code without comments and blanks, in upper case. Comments are in brackets, or follow
/// a semicolon.
Result<std::string> gcodeText(std::string_view line);

/// Reads the words of such a text: letters, and numbers after them. A number is also a parameter
/// (`#1`, `#<name>`, `##2`, `#[1+2]`), an expression in square brackets or a function of one
/// (`SQRT[2]`, `ATAN[1]/[2]`), with the operators and their order of LinuxCNC: `**`, then `*` `/`
/// `MOD`, `+` `-`, `EQ` `NE` `GT` `GE` `LT` `LE`, then `AND` `OR` `XOR`. Angles are in degrees, and
/// numbers that differ by less than a millionth are equal.
class GcodeWords {
 public:
  /// The text and the parameters must outlive this.
  GcodeWords(std::string_view text, const GcodeParameters& parameters)
      : rest_(text), parameters_(parameters) {}

  std::string_view rest() const { return rest_; }
  bool atEnd() const { return rest_.empty(); }
  /// Whether the rest begins with this, which is skipped then.
  bool skip(std::string_view word);
  bool startsNumber() const;

  Result<double> number();
  /// An expression in square brackets.
  Result<double> bracketed();
  /// An expression without brackets around it.
  Result<double> expression() { return expression(1); }

  /// A parameter that is assigned to, after its `#`: its number, or its name.
  struct Parameter {
    std::string name;
    double number = 0;
  };
  Result<Parameter> parameter();

 private:
  Result<double> expression(int leastPrecedence);
  Result<double> function();
  Result<double> arcTangent(double y);
  Result<double> literal();
  Error expected(std::string_view what) const;

  std::string_view rest_;
  const GcodeParameters& parameters_;
  int depth_ = 0;  // of brackets, functions and signs
};

}  // namespace t4d::formats
