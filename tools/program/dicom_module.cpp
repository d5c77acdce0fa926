#include "tools/program/modules.h"

extern "C" const DicomFunctions t4dDicomFunctions = {&t4d::voxel4d::unpackDicomImage};
