#include "tools/t4d/modules.h"

extern "C" const PictureFunctions t4dPictureFunctions = {&t4d::tools::pngOfSvg};
