#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/input_file.h"
#include "model/chords.h"
#include "platform/file_format.h"
#include "t4d/motion.h"
#include "t4d/surface.h"

namespace t4d::formats {

struct GltfAnimationOptions {
  /// The name of the animation, or its number from 0; "all" for all of them together; "" for the
  /// first.
  std::string animation = {};
  /// The name of the scene, or its number from 0; "" for the default one.
  std::string scene = {};
  /// No point of a slice is farther than this from the true solid at the same time, nor the other
  /// way round, in metres; without it, a thousandth of the largest extent of each body at the
  /// first, the middle and the last time.
  std::optional<double> tolerance = {};
  /// The edge factor of the prisms that bodies are swept with (model::Chords).
  double edgeFactor = model::kEdgeFactorOf14;
};

/// A mesh of a node, as it moves.
struct AnimatedBody {
  std::string name;  ///< of the node; no other body has it
  model::TriangleMesh mesh;
  /// The body in time: more than one where it jumps, or is hidden for a while.
  std::vector<std::unique_ptr<model::VertexKeys>> runs;
  std::optional<double> tolerance = {};  ///< of an animation: its own, in length units
};

struct AnimatedScene {
  std::vector<AnimatedBody> bodies;
  /// Keys of a rotation that slerp could join either way round, by node.
  std::vector<model::HalfTurn> halfTurns;
  std::vector<std::string> notices;
  std::vector<std::string> losses;
  std::vector<std::string> otherAnimations;  ///< that are not read: names in quotes, or numbers
  std::vector<std::filesystem::path> otherFiles;  ///< as LoadedMesh::otherFiles
  std::vector<std::string> materials = {};        ///< as LoadedMesh::materials, of all bodies
  std::string lengthUnit = "m";
  std::string up = "y";  ///< or "z"
};

/// glTF, binary or text.
std::vector<platform::FileFormat> animatedGltfFormats();

/// Reads an animation of a glTF 2.0 file, or all of them, which then must not move the same
/// property of a node, from time 0 to the last key: each node of the scene with
/// a mesh is a body. Nodes are translated, rotated and scaled (STEP, LINEAR, CUBICSPLINE), and
/// meshes deformed by skins and morph targets. All instances of a node (EXT_mesh_gpu_instancing)
/// are one body, as all primitives of a mesh are.
///
/// Layers are at all keys that move a body, and between them so that slices are within the
/// tolerance. This is proved, not sampled: of a function with a second derivative of at most a,
/// the chord over a time h is at most h^2 a / 8 away, and a is bounded from the control points of
/// the curves, along the chain of nodes by Leibniz's rule; model::edgeDeviation of the layers
/// bounds what slices are off their vertices.
///
/// Meshes have colours, texture coordinates and materials as those of Keep::Attributes.
///
/// Where a STEP curve changes its value, the body ends and begins anew, each time closed by a cap.
/// It is left out for as long as its scale is zero. A body whose transform mirrors is read
/// mirrored.
Result<AnimatedScene> readGltfAnimation(const InputFile& file, const GltfAnimationOptions& options);

}  // namespace t4d::formats
