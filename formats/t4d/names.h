#pragma once

#include <string>
#include <string_view>

#include "t4d/error.h"

namespace t4d::formats {

/// Fails if the text cannot be the name of a body or an attribute (SPEC.md, "Conventions"): it has
/// to be UTF-8 of 1 to 255 bytes without controls, slashes and characters that change the direction
/// of text. The error completes a sentence that begins with what is named: "has ...", "is ...".
Result<void> checkName(std::string_view text);

/// Whether a text is UTF-8 as the Unicode standard defines it, as JSON needs.
bool isUtf8(std::string_view text);

/// A name as like the text as possible: what is not allowed becomes `_`, and at most 255 bytes are
/// kept.
std::string asName(std::string_view text);

}  // namespace t4d::formats
