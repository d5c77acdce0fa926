#pragma once

#include <string>

#include "t4d/model/error.h"

/// What to try after an error, in terms of verbs and options, which the library does
/// not know.
namespace t4d::tools {

/// A sentence on what to do about the error; empty if there is no advice.
std::string hintFor(const Error& error);

/// The same for a file that was read as .t4d and is invalid.
std::string hintForFile(const std::string& path);

}  // namespace t4d::tools
