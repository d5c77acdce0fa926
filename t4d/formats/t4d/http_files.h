#pragma once

#include "t4d/formats/t4d/http_client.h"
#include "t4d/system/web_files.h"

namespace t4d::formats {

/// Requests files from web servers, each by a connection that is kept for the next.
system::WebFiles httpFiles(HttpTimeouts timeouts = {});

}  // namespace t4d::formats
