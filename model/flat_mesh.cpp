#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "t4d/mesh.h"

namespace t4d::model {
namespace {

/// Makes room for `more` rows after the first `used`. Capacity grows by half, so that rows are
/// seldom moved.
template <class Matrix>
void reserveRows(Matrix& matrix, Eigen::Index used, std::size_t more) {
  const Eigen::Index needed = used + static_cast<Eigen::Index>(more);
  if (needed <= matrix.rows()) return;
  matrix.conservativeResize(std::max(needed, matrix.rows() + matrix.rows() / 2), 4);
}

class Flattener : public Sink {
 public:
  Result<void> put(const Slab& slab) override {
    if (auto checked = checkSlab(slab); !checked) return wrong(checked.error().message);
    const Connectivity& connectivity = *slab.connectivity;
    if (slab.connectivity != checked_) {
      if (auto checked = checkConnectivity(connectivity); !checked) {
        return wrong(checked.error().message);
      }
      checked_ = slab.connectivity;
    }
    const auto lower = slab.lowerLayer();
    if (slabs_ > 0 && !std::ranges::equal(lower, upperLayer_)) {
      return wrong("its lower layer is not the upper layer of the one before");
    }
    // The row of the slab's vertex 0: lower layers after the first are already there.
    const Eigen::Index first =
        vertexCount_ - (slabs_ > 0 ? static_cast<Eigen::Index>(lower.size()) : 0);
    const Eigen::Index end = first + static_cast<Eigen::Index>(slab.vertices.size());
    if (end > std::numeric_limits<std::uint32_t>::max()) {
      return wrong("the mesh has more vertices than 32-bit indices can number");
    }
    reserveRows(mesh_.vertices, first, slab.vertices.size());
    for (std::size_t i = 0; i < slab.vertices.size(); ++i) {
      mesh_.vertices.row(first + static_cast<Eigen::Index>(i)) = slab.vertices[i];
    }
    reserveRows(mesh_.cells, cellCount_, connectivity.cells.size());
    for (const Cell& cell : connectivity.cells) {
      for (int corner = 0; corner < 4; ++corner) {
        mesh_.cells(cellCount_, corner) = static_cast<std::uint32_t>(first) + cell[corner];
      }
      ++cellCount_;
    }
    vertexCount_ = end;
    upperLayer_.assign(slab.upperLayer().begin(), slab.upperLayer().end());
    ++slabs_;
    return {};
  }

  FlatMesh finish() {
    mesh_.vertices.conservativeResize(vertexCount_, 4);
    mesh_.cells.conservativeResize(cellCount_, 4);
    return std::move(mesh_);
  }

 private:
  Error wrong(const std::string& message) const {
    return invalid(message, placeIn({}, fmt::format("slab {}", slabs_)));
  }

  FlatMesh mesh_;  // with spare rows
  Eigen::Index vertexCount_ = 0;
  Eigen::Index cellCount_ = 0;
  std::size_t slabs_ = 0;
  std::vector<Point4> upperLayer_;  // of the last slab
  std::shared_ptr<const Connectivity> checked_;
};

}  // namespace

Result<FlatMesh> flatten(const Source& source, const Progress& progress) {
  Flattener flattener;
  if (auto done = pump(source, flattener, progress); !done) return done.error();
  return flattener.finish();
}

}  // namespace t4d::model
