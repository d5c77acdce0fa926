#pragma once

#include <string>

#include "t4d/model/error.h"

/// What to try after an error, in terms of verbs and options; the library knows neither.
namespace t4d::tools {

/// A sentence on what to do about the error; empty where there is nothing to say.
std::string hintFor(const Error& error);

/// The same for a file that was read as .t4d and is invalid.
std::string hintForFile(const std::string& path);

}  // namespace t4d::tools
