#pragma once

#include <functional>
#include <span>
#include <string>

#include "t4d/model/error.h"
#include "tools/viewer/viewer_page.h"

namespace t4d::tools {

/// Serves the viewer and these files to browsers on this machine, by ranges; nothing else, and
/// nothing is written. Takes a free port for 0. Calls `onReady` with the address of the page, and
/// returns only when it fails. Errors: the port is taken; a file cannot be opened; built without
/// the server.
Result<void> serveViewer(std::span<const ShownFile> files, int port,
                         const std::function<void(const std::string& url)>& onReady);

/// Whether this build has the server.
bool canServe();

}  // namespace t4d::tools
