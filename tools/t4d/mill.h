#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/toolpath/tool_path.h"
#include "mill/mill.h"
#include "t4d/motion.h"
#include "tools/t4d/mill_tools.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/solid_input.h"
#include "tools/t4d/t4d_file.h"
#include "voxel4d/frame_spacing.h"

namespace t4d::tools {

class Members;

/// What says how a tool moves.
enum class ToolPathKind : std::uint8_t {
  Motion,     ///< .json, or a table of poses
  Gcode,      ///< in mm and s
  Locations,  ///< five-axis cutter locations, in mm and s
};

/// A stock, its tools and their path, as files.
struct MillFiles {
  SolidInput stock;  ///< one body
  /// Instead of a file, whose name is "stock" then: "box:100,60,20", with the middle of its top at
  /// the origin, or "box:100,60,20@0,0,-20", with its lowest corner there; length units.
  std::string box = {};
  /// One without a number, or those that the path mounts by their numbers. Not empty.
  MillToolSpecs tools = {};
  ToolPathKind kind = ToolPathKind::Motion;
  std::string path = {};
  formats::MotionTableOptions table = {};  ///< of a motion that is a table of poses
  /// Of G-code and cutter locations. Tolerance, tools, lengths and reach are those of the milling.
  formats::ToolPathOptions program = {};
  std::map<int, formats::TableTool> toolTable = {};  ///< lengths of the tools of G-code
};

struct MillOptions {
  double voxelSize = 1;                  ///< in length units
  std::optional<double> tolerance = {};  ///< as mill::MillOptions; nothing: a hundredth of a voxel
  double travel = 0;                     ///< as mill::MillOptions
  double memory = 4e9;                   ///< as mill::MillOptions
  voxel4d::FrameTimes frames = {.count = 60};
  voxel4d::CapStyle caps = voxel4d::CapStyle::Graded;
  T4dFileOptions output = {};

  double toleranceOr() const { return tolerance.value_or(voxelSize / 100); }
};

/// The contents of these files.
struct MillInput {
  MillFiles files;
  model::TriangleMesh stock;
  std::vector<mill::Tool> tools;
  formats::ToolPath path;
  std::vector<std::string> losses = {};
  double seconds = 0;  ///< that reading took
};

/// What a path does, and how long.
struct PathSummary {
  model::Bounds3 extent = {};          ///< of the tip, in the frame of the stock
  double rapid = 0;                    ///< time
  double dwell = 0;                    ///< seconds, which are no part of the motion
  std::size_t toolChanges = 0;         ///< between tools with numbers
  std::map<int, double> cutting = {};  ///< time, by the number of the tool; 0: one without
};

/// Of a path that has been read.
PathSummary summaryOf(const formats::ToolPath& path);

struct MillReport {
  mill::MillReport milled;
  PathSummary path;
  model::Motion motion;                      ///< of the tool
  std::vector<formats::Mounting> mountings;  ///< of tools with numbers and without
  std::uint64_t bytes = 0;                   ///< of the file
  double seconds = 0;                        ///< with reading and writing
  std::vector<std::string> notices = {};     ///< of milling
  std::vector<std::string> losses = {};
};

/// Reads the files. The observer gets the notices of files, and one if the surface of the stock
/// crosses itself. Fails for a file that cannot be read, no tool, tools with numbers that a motion
/// cannot mount (Options), and a voxel size that is too small for the stock.
Result<MillInput> readMilling(const MillFiles& files, const MillOptions& options,
                              Observer& observer = nobody());

/// Mills (mill::mill) and writes the .t4d. Errors name the file that is at fault. Fails (Options)
/// if the file to write is one of those that were read.
Result<MillReport> mill(const MillInput& input, const MillOptions& options,
                        Observer& observer = nobody());

void describe(Members& members, const MillReport& report);

}  // namespace t4d::tools
