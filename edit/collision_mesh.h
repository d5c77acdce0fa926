#pragma once

#include "t4d/envelope.h"

namespace t4d::edit {

/// An envelope with a reach (EnvelopeOptions) and a limited number of triangles, for collision
/// checks. It still contains every point within the reach.
///
/// The envelope with a larger reach is reduced (reducedSurface), and the result measured
/// (measure::EnclosedPlaces): it is taken if it keeps a distance of the reach at least from the
/// silhouette and encloses it. Otherwise the larger reach grows by what was missing. Surfaces that
/// cross themselves are replaced by their outer surface.
///
/// Envelope::errorBound is the largest distance of a point of the surface from where the solid has
/// been. `losses` says so if there are more triangles than asked for: a connected surface has at
/// least four, and one with holes has more.
///
/// Fails as envelopeOf, without a reach, in a build without meshoptimizer, and if no larger reach
/// is enough.
Result<Envelope> collisionMeshOf(const measure::Silhouette& silhouette, EnvelopeOptions options,
                                 std::size_t triangles, const model::Progress& progress = {});

}  // namespace t4d::edit
