#include "tools/t4d/modules.h"

extern "C" const WebFunctions t4dWebFunctions = {&t4d::formats::openHttpSource};
