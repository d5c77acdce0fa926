#include "t4d/file.h"

namespace t4d::formats {

void readUrls() {}

}  // namespace t4d::formats
