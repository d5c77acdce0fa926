#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "edit/vertex_tracks.h"
#include "t4d/mesh.h"

namespace t4d::edit {

/// A layer of a body or one within a step of it, in the order of time.
struct LayerKey {
  std::size_t step = 0;
  double fraction = 0;  ///< of the step; 0 for a layer of the body

  friend auto operator<=>(const LayerKey&, const LayerKey&) = default;
};

/// The vertices of a layer that move, in increasing order, with their displacements, which are not
/// 0.
using LayerDisplacement = std::vector<std::pair<std::uint32_t, model::Point3>>;

/// The displacements of layers. A step is divided at each layer within it, whether this layer moves
/// or not. Layers of the body need no entry unless they move.
using Displacement = std::map<LayerKey, LayerDisplacement>;

/// The name of the vertex attribute with the displacement: three float32 in length units.
inline constexpr const char* kDisplacementAttribute = "displacement";

/// A body whose layers are displaced, made slab by slab on request. Before displacement, new layers
/// within a step are on the straight tracks of the vertices. Means follow. A slab whose layers
/// neither move nor are new is that of the body, except for the attribute. If the layer at an end
/// moves, the end gets a new cap.
class DisplacedSource : public model::Source {
 public:
  /// `tracks` and its source must outlive this object.
  DisplacedSource(const VertexTracks& tracks, Displacement displacement, bool withAttribute);

  std::size_t slabCount() const override { return slabs_.size(); }
  model::TimeSpan timeSpan(std::size_t index) const override;
  /// Fails if an end cannot get a cap because the surface crosses itself there.
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t index) const override;

  /// Whether slab `index` differs from the body in more than the attribute.
  bool isChanged(std::size_t index) const;

 private:
  struct Piece {
    std::size_t slab;  // of the body
    LayerKey lower;    // equal to `upper` for a cap
    LayerKey upper;
    bool isCap;
  };

  const LayerDisplacement* moved(const LayerKey& key) const;
  double timeOf(const LayerKey& key) const;
  Result<model::Slab> step(const Piece& piece, const model::Slab& from) const;
  Result<model::Slab> cap(const Piece& piece, const model::Slab& from) const;
  void addAttribute(const Piece& piece, model::Slab& slab) const;

  const VertexTracks& tracks_;
  Displacement displacement_;
  bool withAttribute_;
  std::vector<Piece> slabs_;
  mutable std::mutex mutex_;
  mutable std::map<std::size_t, std::shared_ptr<const model::Slab>> caps_;  // new caps
};

/// The point of a track at a fraction of a step.
inline model::Point3 between(const model::Point3& from, const model::Point3& to, double fraction) {
  return fraction == 0 ? from : model::Point3((1 - fraction) * from + fraction * to);
}

}  // namespace t4d::edit
