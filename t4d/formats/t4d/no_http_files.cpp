#include "t4d/formats/t4d/http_files.h"

namespace t4d::formats {

system::WebFiles httpFiles(HttpTimeouts) { return {}; }

}  // namespace t4d::formats
