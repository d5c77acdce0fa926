#pragma once

#include <span>
#include <string>
#include <string_view>

#include "t4d/error.h"

namespace t4d::formats {

struct JsonRules {
  /// Parsers recurse: deeper nesting could overflow the stack. Real files stay below 20.
  int deepestNesting = 200;
  /// Members that must be whole numbers from 0 on, wherever they occur.
  std::span<const std::string_view> wholeNumbers = {};
};

/// Finds what JSON parsers accept without a word: a key that occurs twice in an object, whose
/// values but one are lost. Also checks the rules. Text that is not JSON is left to the parser.
/// `where` of the error is `name`.
Result<void> checkJson(std::string_view text, const Place& name, const JsonRules& rules = {});

}  // namespace t4d::formats
