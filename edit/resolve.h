#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/body.h"
#include "model/slab.h"

namespace t4d::edit {

struct ResolveOptions {
  double clearance = 0;  ///< the distance to keep, in length units; 0: no touching
  /// How far around a contact the surface gives way, in length units; by default three times the
  /// largest displacement, and at least two mean edges.
  std::optional<double> smoothSpace = {};
  /// How long before and after a contact the surface gives way, in time units; by default a tenth
  /// of the body's time.
  std::optional<double> smoothTime = {};
  /// The largest displacement, in length units; by default half of the smallest extent of the body.
  std::optional<double> maxMove = {};
  bool stay = false;  ///< keep dents after the contact
  int maxRounds = 24;
};

/// The solid at the time of a layer.
struct ResolvedLayer {
  double time = 0;
  double volumeBefore = 0;
  double volumeAfter = 0;
  double displacement = 0;  ///< the largest, in length units
};

struct ResolveReport {
  bool changed = false;  ///< false if the body was clear already
  double maxDisplacement = 0;
  double maxDisplacementTime = 0;
  model::Point3 maxDisplacementPlace = model::Point3::Zero();  ///< before displacement
  double volumeChangeMax = 0;  ///< the largest change of the volume at a layer, with its sign
  double hypervolumeChange = 0;
  std::uint64_t rounds = 0;         ///< tests for contact after a change
  std::uint64_t movedVertices = 0;  ///< in all layers together
  std::uint64_t addedLayers = 0;    ///< within steps of the body
  double smoothSpace = 0;           ///< as used
  double smoothTime = 0;
  std::vector<ResolvedLayer> layers;  ///< in time order
};

/// The result of resolve: a body that gives way.
struct ResolvedBody {
  /// The body, with the vertex attribute "displacement" (three float32) if it is changed. Valid as
  /// long as the source that was given.
  std::shared_ptr<const model::Source> source;
  ResolveReport report;
};

/// Deforms `body` in space and time so that it does not touch any of `obstacles` or come nearer
/// than the clearance, by the exact test of cells in space-time (measure/collide.h).
///
/// Vertices of layers that are in an obstacle, or too near, move out along the shortest way. If
/// these ways diverge, as on both sides of a thin plate, they move towards the inside of the body.
/// Around them the surface gives way over `smoothSpace` and `smoothTime`. Where several contacts
/// overlap, the largest displacement counts; what is out of reach of all stays unchanged, bit for
/// bit. Where the bodies touch between layers that are clear, the step is divided. This is repeated
/// until nothing touches.
///
/// The body must keep its triangles, as swept ones do (VertexTracks). Fails with ErrorCode::Failed,
/// with the time and the position, if the body cannot get out of the way within `maxMove`, or if
/// its surface would have to cross itself.
Result<ResolvedBody> resolve(std::span<const model::Body> obstacles, const model::Body& body,
                             const ResolveOptions& options, const model::Progress& progress = {});

}  // namespace t4d::edit
