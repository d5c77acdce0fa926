#pragma once

#include <memory>
#include <string>

#include "formats/t4d/byte_source.h"
#include "formats/t4d/http_client.h"

namespace t4d::formats {

/// Opens a file on a web server, as SPEC.md describes in "Over a network": fetches its last 256
/// KiB, then what is planned and read, in few requests of one range each. Keeps the end of the file
/// and the last 64 MiB or so that it has received. Fails if the file changes.
Result<std::unique_ptr<ByteSource>> openHttpSource(const std::string& url,
                                                   HttpTimeouts timeouts = {});

}  // namespace t4d::formats
