#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "t4d/edit/vertex_tracks.h"
#include "t4d/model/slab.h"

namespace t4d::edit {

/// A layer of a body or one within a step of it, in the order of time.
struct LayerKey {
  std::size_t step = 0;
  double fraction = 0;  ///< of the step; 0 for a layer of the body

  friend auto operator<=>(const LayerKey&, const LayerKey&) = default;
};

/// How far which vertices of a layer move, in the order of the vertices; none of them by 0.
using LayerDisplacement = std::vector<std::pair<std::uint32_t, model::Point3>>;

/// Where the layers of a body go. A layer within a step is there because steps are divided at it,
/// moved or not; those of the body need no entry unless they move.
using Displacement = std::map<LayerKey, LayerDisplacement>;

/// The name of the vertex attribute with the displacement: three float32 in length units.
inline constexpr const char* kDisplacementAttribute = "displacement";

/// A body whose layers are displaced, made slab by slab when they are asked for. New layers within
/// a step are where the straight tracks of the vertices are. Means follow. A slab whose layers
/// neither move nor are new is that of the body, but for the attribute. An end whose layer moves is
/// filled anew.
class DisplacedSource : public model::Source {
 public:
  /// `tracks` and its source must outlive this object.
  DisplacedSource(const VertexTracks& tracks, Displacement displacement, bool withAttribute);

  std::size_t slabCount() const override { return slabs_.size(); }
  model::TimeSpan timeSpan(std::size_t index) const override;
  /// Fails if an end cannot be filled, since the surface crosses itself there.
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t index) const override;

  /// Whether slab `index` differs from the body in more than the attribute.
  bool isChanged(std::size_t index) const;

 private:
  struct Piece {
    std::size_t slab;  // of the body
    LayerKey lower;    // the same two for a cap
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
  mutable std::map<std::size_t, std::shared_ptr<const model::Slab>> caps_;  // filled anew
};

/// The point of a track at a fraction of a step.
inline model::Point3 between(const model::Point3& from, const model::Point3& to, double fraction) {
  return fraction == 0 ? from : model::Point3((1 - fraction) * from + fraction * to);
}

}  // namespace t4d::edit
