#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/model/body.h"
#include "t4d/model/slab.h"

namespace t4d::edit {

struct ResolveOptions {
  double clearance = 0;  ///< the distance to keep, in length units; 0: not to touch
  /// How far the surface gives way around a contact, in length units; by default three times the
  /// largest displacement, and at least two mean edges.
  std::optional<double> smoothSpace = {};
  /// How long before and after a contact, in time units; by default a tenth of the body's time.
  std::optional<double> smoothTime = {};
  /// The largest displacement, in length units; by default half of the smallest extent of the body.
  std::optional<double> maxMove = {};
  bool stay = false;  ///< dents stay for good, instead of healing
  int maxRounds = 24;
};

/// A solid at the time of a layer.
struct ResolvedLayer {
  double time = 0;
  double volumeBefore = 0;
  double volumeAfter = 0;
  double displacement = 0;  ///< the largest, in length units
};

struct ResolveReport {
  bool changed = false;  ///< if not, the body was clear already
  double maxDisplacement = 0;
  double maxDisplacementTime = 0;
  model::Point3 maxDisplacementPlace = model::Point3::Zero();  ///< before
  double volumeChangeMax = 0;  ///< the largest change of the volume at a layer, with its sign
  double hypervolumeChange = 0;
  std::uint64_t rounds = 0;         ///< tests for contact after a change
  std::uint64_t movedVertices = 0;  ///< of all layers together
  std::uint64_t addedLayers = 0;    ///< within steps of the body
  double smoothSpace = 0;           ///< as used
  double smoothTime = 0;
  std::vector<ResolvedLayer> layers;  ///< in time order
};

/// A body that gives way.
struct ResolvedBody {
  /// The body, with the vertex attribute "displacement" (three float32) if it is changed. Valid as
  /// long as the source that was given.
  std::shared_ptr<const model::Source> source;
  ResolveReport report;
};

/// Deforms `body` in space and time such that it does not meet any of `obstacles`, nor comes nearer
/// than the clearance, by the exact test of cells in space-time (measure/collide.h).
///
/// Vertices of layers that lie in an obstacle, or too near, move out along the nearest way; if that
/// leads apart, as on both sides of a thin plate, towards the inside of the body. Around them
/// the surface gives way over `smoothSpace` and `smoothTime`, by the largest of what each contact
/// asks for there, so that no contact is lowered and what is out of reach stays as it is, bit for
/// bit. Where the body touches between layers that are clear, the step is divided. This is repeated
/// until nothing meets.
///
/// The body must keep its triangles, as swept ones do (VertexTracks). Fails with ErrorCode::Failed,
/// saying when and where, if it cannot get out of the way within `maxMove`, and if its surface
/// would have to cross itself.
Result<ResolvedBody> resolve(std::span<const model::Body> obstacles, const model::Body& body,
                             const ResolveOptions& options, const model::Progress& progress = {});

}  // namespace t4d::edit
