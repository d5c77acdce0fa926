#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "edit/mend_steps.h"
#include "t4d/motion.h"

/// Keys of a surface that was made of another one, whose vertices it follows.
namespace t4d::edit {

/// Two vertices that became one, and how far apart they may be.
struct MergedPair {
  std::uint32_t kept;
  std::uint32_t gone;
  double apart;  ///< along any axis
};

/// Each vertex is in the middle of two others. Reading a key fails where merged vertices are apart.
class KeysOfOrigins : public model::VertexKeys {
 public:
  /// `all` has so many vertices. `mesh` are the vertices that poses move, if there are any.
  KeysOfOrigins(std::shared_ptr<const model::VertexKeys> all, std::size_t vertices,
                std::vector<VertexOrigin> origins, std::vector<MergedPair> merged,
                std::shared_ptr<const std::vector<model::Point3>> mesh);

  std::uint64_t count() const override { return all_->count(); }
  double time(std::uint64_t key) const override { return all_->time(key); }
  std::optional<model::Affine3x4> pose(std::uint64_t key) const override { return all_->pose(key); }
  Result<void> positions(std::uint64_t key, std::span<model::Point3> into) const override;

 private:
  std::shared_ptr<const model::VertexKeys> all_;
  mutable std::vector<model::Point3> places_;
  std::vector<VertexOrigin> origins_;
  std::vector<MergedPair> merged_;
  std::shared_ptr<const std::vector<model::Point3>> mesh_;
};

/// Sheets with a thickness: at each key their vertices are half of it along the normals of the
/// vertices, by the areas of triangles, and each has another one on the other side.
class KeysOfThickSheets : public model::VertexKeys {
 public:
  /// The triangles of sheets face the side of the vertices in `sheet`; those on the other side
  /// follow all vertices, in this order.
  KeysOfThickSheets(std::shared_ptr<const model::VertexKeys> all,
                    std::vector<model::Triangle> triangles, std::vector<std::uint32_t> sheet,
                    double thickness);

  std::uint64_t count() const override { return all_->count(); }
  double time(std::uint64_t key) const override { return all_->time(key); }
  Result<void> positions(std::uint64_t key, std::span<model::Point3> into) const override;

 private:
  std::shared_ptr<const model::VertexKeys> all_;
  std::vector<model::Triangle> triangles_;
  std::vector<std::uint32_t> sheet_;
  double thickness_;
};

}  // namespace t4d::edit
