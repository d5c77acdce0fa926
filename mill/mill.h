#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/surface.h"
#include "t4d/weave.h"

/// What a tool leaves of a stock, at any time, as a 4D mesh.
namespace t4d::mill {

/// Fails as mill() does for a voxel size that is too small for the stock: to ask before a tool and
/// a path are made to its tolerance.
Result<void> checkVoxelSize(const model::TriangleMesh& stock, double voxelSize, double memory);

/// A solid that moves with the tool and must not touch the stock.
struct Guard {
  std::string name = {};  ///< "shank", "holder"
  model::TriangleMesh mesh = {};
};

/// A tool, and what holds it, in one pose.
struct Tool {
  model::TriangleMesh mesh = {};
  std::vector<Guard> guards = {};
  int number = 0;  ///< 0: it has none
};

/// "shank", "shank of T2"; "tool", "tool T2".
std::string partOfTool(const std::string& part, int number);

/// Which of the tools given moves with the spindle from this time on, or none.
struct Mounting {
  double time = 0;
  std::optional<std::size_t> tool = {};
};

/// That of the tool with this number, 0 for one without; nothing for no tool.
Mounting mountingOf(std::span<const Tool> tools, double time, std::optional<int> number);

struct MillOptions {
  double voxelSize = 1;  ///< length units; lattice points are its multiples
  /// The times of the frames, increasing, within the motion: at least two.
  std::vector<double> times = {};
  /// Length units; the farthest that points of the tool are from their true paths as it turns.
  double tolerance = 0.01;
  /// How far the tip goes at most in a step, in length units; 0: four voxels.
  double travel = 0;
  double memory = 4e9;  ///< the most bytes for the stock's field
  /// In order of time; before the first there is no tool. If empty, the first tool is mounted.
  std::vector<Mounting> mountings = {};
  std::vector<model::TimeSpan> rapids = {};  ///< times at which the tool must not cut
  voxel4d::CapStyle caps = voxel4d::CapStyle::Graded;
};

/// A contact that must not be: of a guard with the stock, or of the tool in a rapid move.
struct Collision {
  std::string part;      ///< the guard, or "tool"
  int tool = 0;          ///< its number
  model::TimeSpan time;  ///< of the steps in which it is
  model::Point3 point;   ///< in the first of them, where it is deepest
};

/// The stock falls apart.
struct Separation {
  /// From the beginning of the step until the tip has gone a voxel farther than in it: a wall that
  /// is thinner than a voxel is lost before it is cut.
  model::TimeSpan time;
  std::uint64_t components = 0;  ///< after it
};

struct MillProgress {
  double time = 0;
  double removedVolume = 0;
  std::uint64_t components = 0;
};

struct MillReport {
  double stockVolume = 0;  ///< of the first frame, the stock as the voxels have it
  double removedVolume = 0;
  double remainingVolume = 0;
  /// The most that comes back between frames and goes again: the projected volume of the cells that
  /// enter in time. Where a lattice point changes sides, the triangles of the surface about it
  /// change, and new ones can lie a little outside of the old ones. No slice has more than this
  /// outside of all slices before it. The nearer frames are, the more of it: up to about a
  /// hundredth of what is removed.
  double returnedVolume = 0;
  std::uint64_t components = 0;  ///< at the end
  std::uint64_t steps = 0;
  std::vector<MillProgress> progress;  ///< one for each frame
  std::vector<Separation> separations;
  std::vector<Collision> collisions;
  std::optional<double> firstCut;  ///< the beginning of the first step that removes something
  voxel4d::WeaveReport woven;
  std::vector<std::string> notices;  ///< one sentence each
};

/// Mills `stock` with `tools` moved by `motion`, one at a time, and puts the workpiece into `sink`,
/// a 4D mesh woven from frames.
///
/// Between two frames the tool goes in steps, of each of which the envelope is removed: all places
/// where the swept tool, a 4D mesh, has been in that step (measure::SlabSilhouettes). So nothing
/// stays between two poses, and what has been removed never comes back: no value of the field
/// falls. At a frame the surface is off by the order of the square of the voxel size where it is
/// smooth, and by the voxel size at edges and in gaps narrower than a voxel. Between frames the
/// mesh is straight in time. The first frame is the stock before the first step.
///
/// Guards are looked at after each step, with lattice points: what they reach by less than a voxel
/// may be missed, and what is found is a contact for certain.
///
/// Both meshes are closed; one that is inside out is turned round, with a notice for the stock.
/// Where the stock overlaps itself it counts once. Memory is that of a few frames. Fails for a mesh
/// that is not closed ("stock" or partOfTool() is where), a voxel size that needs
/// more than `memory` or at which no lattice point is inside the stock, a tool or guard too large
/// for it, times that are not within the motion, and if sweep, weave or the sink does.
Result<MillReport> mill(const model::TriangleMesh& stock, std::span<const Tool> tools,
                        const model::Motion& motion, const MillOptions& options, model::Sink& sink,
                        const model::Progress& progress = {});

}  // namespace t4d::mill
