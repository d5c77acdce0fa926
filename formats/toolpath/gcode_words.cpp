#include "formats/toolpath/gcode_words.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "formats/text/text_scanner.h"
#include "model/degrees.h"
#include "model/number.h"

namespace t4d::formats {
namespace {

constexpr double kEqual = 1e-6;  // as in LinuxCNC

// Deeper brackets would fill the stack.
constexpr int kDeepestBrackets = 100;

struct Operator {
  std::string_view name;
  int precedence;
  double (*apply)(double, double);
};

double truth(bool is) { return is ? 1 : 0; }

double modulo(double a, double b) {
  const double rest = std::fmod(a, b);
  return rest < 0 ? rest + std::abs(b) : rest;
}

constexpr std::array<Operator, 15> kOperators = {{
    {"**", 5, [](double a, double b) { return std::pow(a, b); }},
    {"*", 4, [](double a, double b) { return a * b; }},
    {"/", 4, [](double a, double b) { return a / b; }},
    {"MOD", 4, modulo},
    {"+", 3, [](double a, double b) { return a + b; }},
    {"-", 3, [](double a, double b) { return a - b; }},
    {"EQ", 2, [](double a, double b) { return truth(std::abs(a - b) < kEqual); }},
    {"NE", 2, [](double a, double b) { return truth(!(std::abs(a - b) < kEqual)); }},
    {"GT", 2, [](double a, double b) { return truth(a > b); }},
    {"GE", 2, [](double a, double b) { return truth(a >= b); }},
    {"LT", 2, [](double a, double b) { return truth(a < b); }},
    {"LE", 2, [](double a, double b) { return truth(a <= b); }},
    {"AND", 1, [](double a, double b) { return truth(a != 0 && b != 0); }},
    {"XOR", 1, [](double a, double b) { return truth((a != 0) != (b != 0)); }},
    {"OR", 1, [](double a, double b) { return truth(a != 0 || b != 0); }},
}};

struct Function {
  std::string_view name;
  double (*apply)(double);
};

constexpr std::array<Function, 12> kFunctions = {{
    {"ABS", [](double x) { return std::abs(x); }},
    {"ACOS", [](double x) { return std::acos(x) * model::kDegreesPerRadian; }},
    {"ASIN", [](double x) { return std::asin(x) * model::kDegreesPerRadian; }},
    {"COS", [](double x) { return std::cos(x / model::kDegreesPerRadian); }},
    {"EXP", [](double x) { return std::exp(x); }},
    {"FIX", [](double x) { return std::floor(x); }},
    {"FUP", [](double x) { return std::ceil(x); }},
    {"LN", [](double x) { return std::log(x); }},
    {"ROUND", [](double x) { return std::round(x); }},
    {"SIN", [](double x) { return std::sin(x / model::kDegreesPerRadian); }},
    {"SQRT", [](double x) { return std::sqrt(x); }},
    {"TAN", [](double x) { return std::tan(x / model::kDegreesPerRadian); }},
}};

constexpr std::string_view kArcTangent = "ATAN";
constexpr std::string_view kExists = "EXISTS";

bool isDigit(char c) { return (c >= '0' && c <= '9') || c == '.'; }

}  // namespace

Result<std::string> gcodeText(std::string_view line) {
  std::string text;
  bool comment = false;
  for (const char c : line) {
    if (comment) {
      comment = c != ')';
    } else if (c == '(') {
      comment = true;
    } else if (c == ')' && !text.starts_with('%')) {
      return invalid("a closing bracket has no opening one: comments cannot be nested");
    } else if (c == ';') {
      break;
    } else if (c != ' ' && c != '\t') {
      text += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    }
  }
  if (comment) return invalid("a comment has no closing bracket");
  return text;
}

bool GcodeWords::skip(std::string_view word) {
  if (!rest_.starts_with(word)) return false;
  rest_.remove_prefix(word.size());
  return true;
}

Error GcodeWords::expected(std::string_view what) const {
  return invalid(rest_.empty() ? fmt::format("the line ends, expected {}", what)
                               : fmt::format("found {}, expected {}", inQuotes(rest_), what));
}

bool GcodeWords::startsNumber() const {
  if (rest_.empty()) return false;
  if (isDigit(rest_[0]) || std::string_view("+-#[").find(rest_[0]) != std::string_view::npos) {
    return true;
  }
  const auto isNext = [&](std::string_view name) { return rest_.starts_with(name); };
  return isNext(kArcTangent) || isNext(kExists) ||
         std::ranges::any_of(kFunctions, isNext, &Function::name);
}

Result<double> GcodeWords::number() {
  if (depth_ >= kDeepestBrackets) {
    return invalid(
        fmt::format("brackets, signs and functions are more than {} deep", kDeepestBrackets));
  }
  ++depth_;
  const auto read = [&]() -> Result<double> {
    if (rest_.starts_with('[')) return bracketed();
    if (skip("#")) {
      const auto which = parameter();
      if (!which) return which.error();
      return which->name.empty() ? parameters_.value(which->number)
                                 : parameters_.value(which->name);
    }
    const bool isSigned = rest_.starts_with('+') || rest_.starts_with('-');
    if (isSigned && rest_.size() > 1 && !isDigit(rest_[1])) {
      const double sign = rest_[0] == '-' ? -1 : 1;
      rest_.remove_prefix(1);
      auto value = number();
      if (value) *value *= sign;
      return value;
    }
    return isSigned || (!rest_.empty() && isDigit(rest_[0])) ? literal() : function();
  }();
  --depth_;
  return read;
}

Result<double> GcodeWords::literal() {
  std::string_view digits = rest_;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  const auto value = model::takeNumber<double>(digits, std::chars_format::fixed);
  if (!value || !std::isfinite(*value)) return expected("a number");
  rest_ = digits;
  return *value;
}

Result<double> GcodeWords::function() {
  if (skip(kExists)) {
    if (!skip("[#")) return expected("[# and a parameter after EXISTS");
    const auto which = parameter();
    if (!which) return which.error();
    if (!skip("]")) return expected("] after the parameter of EXISTS");
    return truth(which->name.empty() ? parameters_.exists(which->number)
                                     : parameters_.exists(which->name));
  }
  const bool isArcTangent = skip(kArcTangent);
  const auto found = std::ranges::find_if(
      kFunctions, [&](const Function& one) { return !isArcTangent && skip(one.name); });
  if (!isArcTangent && found == kFunctions.end()) return expected("a number");
  const auto argument = bracketed();
  if (!argument) return argument;
  if (isArcTangent) return arcTangent(*argument);
  const double value = found->apply(*argument);
  if (std::isfinite(value)) return value;
  return invalid(fmt::format("{}[{:g}] is not a number", found->name, *argument));
}

Result<double> GcodeWords::arcTangent(double y) {
  if (!skip("/")) return expected("/ and the second number of ATAN in brackets");
  const auto x = bracketed();
  if (!x) return x;
  return std::atan2(y, *x) * model::kDegreesPerRadian;
}

Result<double> GcodeWords::bracketed() {
  if (!skip("[")) return expected("an expression in square brackets");
  auto value = expression(1);
  if (!value) return value;
  if (!skip("]")) return expected("an operator or ]");
  return value;
}

Result<double> GcodeWords::expression(int leastPrecedence) {
  auto value = number();
  while (value) {
    const auto found = std::ranges::find_if(
        kOperators, [&](const Operator& one) { return rest_.starts_with(one.name); });
    if (found == kOperators.end() || found->precedence < leastPrecedence) return value;
    rest_.remove_prefix(found->name.size());
    const auto right = expression(found->precedence + 1);
    if (!right) return right;
    const double result = found->apply(*value, *right);
    if (!std::isfinite(result)) {
      return invalid(fmt::format("{:g} {} {:g} is not a number", *value, found->name, *right));
    }
    value = result;
  }
  return value;
}

Result<GcodeWords::Parameter> GcodeWords::parameter() {
  Parameter which;
  if (!skip("<")) {
    const auto value = number();
    if (!value) return value.error();
    which.number = *value;
    return which;
  }
  const auto end = rest_.find('>');
  if (end == rest_.npos || end == 0) return expected("the name of a parameter, as in #<depth>");
  which.name = rest_.substr(0, end);
  rest_.remove_prefix(end + 1);
  return which;
}

}  // namespace t4d::formats
