#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "t4d/error.h"

namespace t4d::tools {

struct ServedFile {
  std::string name;  ///< its address beside the page
  std::filesystem::path path;
};

/// Serves the page and these files to browsers on this machine, by ranges; nothing else, and
/// nothing is written. Takes a free port for 0. Calls `onReady` with the address of the page, and
/// returns only when it fails. Errors: the port is taken; a file cannot be opened; built without
/// the server.
Result<void> serveViewer(const std::string& page, std::span<const ServedFile> files, int port,
                         const std::function<void(const std::string& url)>& onReady);

/// Whether this build has the server.
bool canServe();

}  // namespace t4d::tools
