#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/error.h"

/// Output files of which each has one body: `link-{body}.stl`.
namespace t4d::tools {

/// Whether an output stands for one file per body.
bool isPerBody(const std::string& output);

/// Why the output cannot stand for one file per body: `{body}` is in the name of a folder.
std::optional<std::string> misuseOfPerBody(const std::string& output);

/// The files, `{body}` replaced by each name, which has no '/' (formats::checkName). Fails if one
/// exists and was not written by t4d.
Result<std::vector<std::filesystem::path>> bodyFiles(const std::string& output,
                                                     std::span<const std::string> bodies);

}  // namespace t4d::tools
