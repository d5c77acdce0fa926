#pragma once

#include "formats/t4d/http_source.h"
#include "t4d/frames.h"
#include "t4d/weave.h"
#include "tools/report/svg_picture.h"
#include "voxel4d/advected_frames.h"
#include "voxel4d/point_field.h"
#include "voxel4d/point_field_parts.h"

/// Loading OpenVDB, libcurl and librsvg takes several times as long as all else that a short
/// run does, and most verbs never use them. So the program does not link them: modules have the
/// functions of the library that need them, and each is loaded by the first call of one of its
/// functions (module_functions.cpp). Everything else links the library as it is.
///
/// A module exports a table of its functions.
struct OpenVdbFunctions {
  static constexpr const char* kModule = "t4d_openvdb.so";
  static constexpr const char* kTable = "t4dOpenVdbFunctions";

  decltype(&t4d::voxel4d::openVdbFrames) openVdbFrames;
  decltype(&t4d::voxel4d::advectedFrames) advectedFrames;
  decltype(&t4d::voxel4d::voxelFrames) voxelFrames;
  decltype(&t4d::voxel4d::writeVoxelFrames) writeVoxelFrames;
  decltype(&t4d::voxel4d::writePointField) writePointField;
  decltype(&t4d::voxel4d::joinPointFields) joinPointFields;
};

struct WebFunctions {
  static constexpr const char* kModule = "t4d_web.so";
  static constexpr const char* kTable = "t4dWebFunctions";

  decltype(&t4d::formats::openHttpSource) openHttpSource;
};

struct PictureFunctions {
  static constexpr const char* kModule = "t4d_picture.so";
  static constexpr const char* kTable = "t4dPictureFunctions";

  decltype(&t4d::tools::pngOfSvg) pngOfSvg;
};

extern "C" const OpenVdbFunctions t4dOpenVdbFunctions;
extern "C" const PictureFunctions t4dPictureFunctions;
extern "C" const WebFunctions t4dWebFunctions;
