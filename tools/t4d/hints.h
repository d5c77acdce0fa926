#pragma once

#include <string>

#include "t4d/error.h"

/// Hints on what to try after an error, in terms of verbs and options, which the library does not
/// know.
namespace t4d::tools {

/// A sentence on what to do about the error; empty if there is no advice.
std::string hintFor(const Error& error);

/// Which program exports a model of a format that is not read, such as .blend, as one that is;
/// empty for all other files.
std::string exportHint(const std::string& path);

/// A sentence on what to do about a file that was read as .t4d and is invalid.
std::string hintForFile(const std::string& path);

}  // namespace t4d::tools
