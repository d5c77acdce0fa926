#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "t4d/mesh.h"

/// Facets are the triangles of the cells. In a closed, oriented mesh each has two cells, on
/// opposite sides. This depends only on the connectivity, so slabs that share one are checked once.
namespace t4d::model {

/// Three vertices in increasing order, and whether sorting them took an even permutation.
struct OrientedFacet {
  std::array<std::uint32_t, 3> vertices;
  bool even;
};

OrientedFacet orientedFacet(std::uint32_t a, std::uint32_t b, std::uint32_t c);

/// The facet opposite a corner (0 to 3) of a cell, oriented as in the cell's boundary: for a
/// positively oriented tetrahedron in space, counter-clockwise seen from outside.
OrientedFacet facetOpposite(const Cell& cell, int corner);

/// A triangle of the mesh, and the number of cells that have it in each orientation.
struct Facet {
  std::array<std::uint32_t, 3> vertices;  ///< increasing
  std::uint32_t even = 0;                 ///< cells whose boundary has it in this orientation
  std::uint32_t odd = 0;                  ///< cells whose boundary has it in the opposite one
  std::uint32_t cell = 0;                 ///< the first of these cells

  bool isClosed() const { return even + odd == 2; }
  bool isMatched() const { return even == 1 && odd == 1; }
};

/// The facets of one slab that are not matched within it.
struct FacetTopology {
  /// Facets outside the layers without exactly one cell on each side: errors in the mesh.
  std::vector<Facet> unmatched;
  /// Facets with all vertices in one layer, in increasing order. They may be matched or not, since
  /// the neighbouring slab may have cells there too. Vertices are numbered from the first of the
  /// layer.
  std::vector<Facet> lower;
  std::vector<Facet> upper;
};

FacetTopology facetTopology(const Connectivity& connectivity);

/// facetTopology in several parts, which can be computed concurrently. Each part has the facets
/// whose smallest vertex is in one range; in the order of the parts they are those of
/// facetTopology. A part takes 16 bytes per facet; all parts together take 64 bytes per cell.
class FacetParts {
 public:
  explicit FacetParts(const Connectivity& connectivity);

  std::size_t size() const { return begin_.size() - 1; }
  FacetTopology topology(std::size_t part) const;

 private:
  struct Run {
    std::uint32_t
        lowest;  // smallest vertex of a facet of some cells; `highest`: the largest of these
    std::uint32_t highest;
  };

  const Connectivity& connectivity_;
  std::vector<std::uint32_t> begin_;   // start of the range of each part, and the end of the last
  std::vector<std::uint64_t> facets_;  // by smallest vertex
  std::vector<Run> runs_;
};

/// The facets of a seam that do not have exactly one cell on each side, given the upper facets of
/// the slab before it and the lower facets of the slab after it. Facet::cell is a cell of the slab
/// before or, if only the slab after has the facet, of that slab.
std::vector<Facet> unmatchedAtSeam(const std::vector<Facet>& before,
                                   const std::vector<Facet>& after);

}  // namespace t4d::model
