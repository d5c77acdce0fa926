#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "conformance/oracle.h"
#include "fixtures/fields.h"
#include "mill/tool_shape.h"
#include "model/motion.h"
#include "model/triangle_mesh.h"

/// Moving solids whose relevant properties are known in closed form.
namespace t4d::conformance {

/// A solid bounded by a triangle mesh, and how it moves.
struct MovingMesh {
  model::TriangleMesh mesh;
  double volume = 0;        ///< of the solid, in closed form if there is one
  std::vector<int> genera;  ///< of its surfaces, in descending order
  std::string motionText;   ///< the text of a motion file (docs/motion.md)
  model::Motion motion;     ///< the same motion, parsed
};

/// A box whose face at its smallest x the moving solid first touches at a known time.
struct Obstacle {
  std::shared_ptr<const model::Source> source;
  double faceX = 0;        ///< at the start
  double faceSpeed = 0;    ///< along x
  model::Point3 touching;  ///< the point of the solid that touches first, at the start
  double time = 0;         ///< of the first contact
  /// The point moves towards the face at least at this speed until it is `depth` behind the face.
  double leastSpeed = 0;
  double depth = 0;
  bool canGiveWay = false;  ///< whether edit::resolve can move the swept solid out of the way
};

/// A field as the rest of a stock after milling.
struct Milling {
  model::TriangleMesh stock;
  mill::ToolShape tool;
  model::Point3 start;   ///< of the tip
  model::Motion motion;  ///< of the tool, from its position at the start
};

/// How voxel4d runs a case.
struct VoxelPlan {
  /// Descending, in length units; each half of the one before. Empty: not a voxel case.
  std::vector<double> voxelSizes;
  /// Store the lattice points inside instead of distances, with one frame per unit of time and a
  /// single voxel size.
  bool mask = false;
  std::size_t maskFrames = 0;
  double maskVolume = 0;         ///< volume of the slice at each frame
  std::optional<Counts> counts;  ///< if known
  /// For a field: store the lattice points inside instead of distances, with frames between which
  /// its surface moves by this many voxels. 0 stores distances.
  double maskMotion = 0;
  double order = 2;  ///< of convergence, when voxels and the time between frames are halved
};

/// Properties of a surface that determine the voxel error.
struct Surface {
  double area = 0;
  /// The sum over all edges of length times |difference of the two normals|; where the surface is
  /// smooth, the integral of the sum of the two principal curvatures, both taken positive.
  double bending = 0;
};

struct Case {
  std::string id;
  std::string description;
  /// What moves: exactly one of these two is set.
  std::optional<MovingMesh> mesh;
  std::optional<fixtures::Field> field;
  /// Surface of the field at a time; an upper bound if there is no single formula.
  std::function<Surface(double time)> fieldSurface;
  std::optional<Milling> milling;  ///< how a tool makes the field, if one can
  /// The integral over space of the number of visits to each point, for solids that rest or move
  /// along a straight line.
  std::optional<double> visitsVolume;
  /// The mean over the surface of its speed along its normal, for solids that rest or move along a
  /// straight line.
  std::optional<double> meanNormalSpeed;
  std::optional<Obstacle> obstacle;  ///< of a mesh
  /// R_Vmin for mesh4d (mesh4d/steps.h).
  double minVolumeRatio = 0.998;
  /// Counts for mesh4d with TetGen caps, if the total is known.
  std::optional<Counts> meshCounts;
  VoxelPlan voxels;
  bool large = false;  ///< skipped in a quick run

  model::TimeSpan time() const;
  double volumeAt(double time) const;
  std::optional<double> hypervolume() const;
  /// The times at which the oracle slices: both ends, and times at odd fractions between them.
  std::vector<double> sliceTimes() const;
};

/// All cases, in listing order. Ids are words joined by hyphens.
std::vector<Case> analyticCases();

}  // namespace t4d::conformance
