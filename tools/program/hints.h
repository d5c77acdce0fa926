#pragma once

#include <string>

#include "t4d/model/error.h"

/// What to try after an error or a notice, in terms of verbs and options, which the library does
/// not know.
namespace t4d::tools {

/// A sentence on what to do about the error; empty if there is no advice.
std::string hintFor(const Error& error);

/// The same for a file that was read as .t4d and is invalid.
std::string hintForFile(const std::string& path);

/// The notice, and what to do about it, if there is advice.
std::string withAdvice(std::string notice);

}  // namespace t4d::tools
