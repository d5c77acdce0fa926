#pragma once

#include <string>

#include "t4d/model/error.h"

namespace t4d::tools {

/// The command to try on a damaged .t4d; empty where it would save no slab. The file that it names
/// as its output does not exist.
std::string recoveryCommand(const std::string& path);

/// The same for the file that an error is about; empty where the error is no damage.
std::string recoveryCommand(const Error& error);

}  // namespace t4d::tools
