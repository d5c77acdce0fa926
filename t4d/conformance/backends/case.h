#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "t4d/conformance/oracle.h"
#include "t4d/fixtures/fields.h"
#include "t4d/model/motion.h"
#include "t4d/model/triangle_mesh.h"

/// Moving solids of which all that matters is known in closed form.
namespace t4d::conformance {

/// A solid bounded by a triangle mesh, and how it moves.
struct MovingMesh {
  model::TriangleMesh mesh;
  double volume = 0;        ///< of the solid, in closed form where there is one
  std::vector<int> genera;  ///< of its surfaces, in descending order
  std::string motionText;   ///< what a motion file would hold (docs/motion.md)
  model::Motion motion;     ///< the same
};

/// How voxel4d runs a case.
struct VoxelPlan {
  /// Descending, in length units; each half of the one before. Empty: not a case for voxels.
  std::vector<double> voxelSizes;
  /// Lattice points inside instead of distances, a frame each unit of time; with the one voxel
  /// size.
  bool mask = false;
  std::size_t maskFrames = 0;
  double maskVolume = 0;         ///< of the slice at each frame
  std::optional<Counts> counts;  ///< where they are known
};

/// What errors of voxels depend on.
struct Surface {
  double area = 0;
  /// The sum over all edges of length times |difference of the two normals|; where it is smooth,
  /// the integral of the sum of the two principal curvatures, both taken positive.
  double bending = 0;
};

struct Case {
  std::string id;
  std::string description;
  /// What moves: one of the two.
  std::optional<MovingMesh> mesh;
  std::optional<fixtures::Field> field;
  /// Of a field at a time; a bound where it is no one formula.
  std::function<Surface(double time)> fieldSurface;
  /// R_Vmin of mesh4d (t4d/mesh4d/steps.h).
  double minVolumeRatio = 0.998;
  /// Of mesh4d, with ends closed by TetGen, where they are known as a whole.
  std::optional<Counts> meshCounts;
  VoxelPlan voxels;
  bool large = false;  ///< left out of a quick run

  model::TimeSpan time() const;
  double volumeAt(double time) const;
  std::optional<double> hypervolume() const;
  /// At which the oracle cuts: both ends, and times at odd fractions between them.
  std::vector<double> sliceTimes() const;
};

/// All of them, in the order in which they are listed. Ids are words joined by hyphens.
std::vector<Case> analyticCases();

}  // namespace t4d::conformance
