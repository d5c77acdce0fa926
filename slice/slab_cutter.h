#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "model/layered_slab.h"
#include "model/shared_parts.h"
#include "model/slab_blocks.h"
#include "slice/cut.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"

namespace t4d::slice {

/// Slice::blocksRead counts blocks of this many cells.
inline constexpr std::uint64_t kBlockCells = 65536;

/// The section of a slab.
struct CutSlab {
  model::VertexCounts counts;
  std::shared_ptr<const Cut> cut;
  std::vector<model::Point3> positions;  // of each point of the cut
  std::vector<double> fractions;         // of each point on its edge, from below to above
  std::vector<const model::Attribute*> attributes;  // of the slab, unless it was cut by blocks
  SurfaceMotion motion;                             // if requested
  std::uint64_t blocksRead = 0;
};

/// A slab to cut, in one of three forms: whole, readable by blocks, or without its means. The
/// others are null.
struct OpenSlab {
  std::shared_ptr<const model::Slab> slab;
  std::shared_ptr<const model::SlabBlocks> blocks;
  std::shared_ptr<const model::LayeredSlab> layered;

  bool none() const { return !slab && !blocks && !layered; }
};
/// Opens a slab: by blocks if the source offers them, otherwise whole.
Result<OpenSlab> openSlab(const model::Source& source, std::size_t index);
/// Opens a slab for a hyperplane that few cells meet: by blocks or without means if the source
/// offers that.
Result<OpenSlab> openPartly(const model::Source& source, std::size_t index);

/// The cells of a connectivity in runs of kRunCells, the cells of a prism (the paper, section 4.1).
struct CellRuns {
  static constexpr std::uint32_t kRunCells = 14;
  static constexpr std::size_t kSupport = 6;

  std::shared_ptr<const model::Connectivity> connectivity;
  /// For each run, the at most kSupport vertices of which all its other vertices are means. If
  /// there are more, the first entry is kUnknown.
  static constexpr std::uint32_t kUnknown = ~0U;
  std::vector<std::array<std::uint32_t, kSupport>> supports;
};

/// Remembers the last cut, which is often the same in the next slab or at the next time. Safe to
/// use from several threads at once.
class CutMemory {
 public:
  /// Calls checkConnectivity, unless this connectivity was the last one that passed.
  Result<void> check(const std::shared_ptr<const model::Connectivity>& connectivity);
  std::shared_ptr<const Cut> cut(const std::shared_ptr<const model::Connectivity>& connectivity,
                                 std::vector<std::uint8_t> sides);
  std::shared_ptr<const CellRuns> runs(
      const std::shared_ptr<const model::Connectivity>& connectivity);
  /// Whether the slab is made of prisms (prisms.h).
  bool hasPrisms(const std::shared_ptr<const model::Connectivity>& connectivity);

 private:
  model::SharedParts<const model::Connectivity*, CellRuns> runs_;
  model::SharedParts<const model::Connectivity*, bool> prisms_;
  std::mutex mutex_;
  std::shared_ptr<const model::Connectivity> checked_;
  std::shared_ptr<const model::Connectivity> connectivity_;
  std::vector<std::uint8_t> sides_;
  std::shared_ptr<const Cut> last_;
};

/// Cuts slabs by a hyperplane. Safe to use from several threads at once.
class SlabCutter {
 public:
  /// The motion is computed for slabs that are whole or in blocks, and for hyperplanes of constant
  /// time.
  SlabCutter(const Hyperplane& hyperplane, OnHyperplane rule, std::shared_ptr<CutMemory> memory,
             WithMotion withMotion = WithMotion::No);

  const HyperplaneBasis& basis() const { return basis_; }
  /// Whether the hyperplane cuts nothing within these bounds. This is exact, since the rounded n.p
  /// is monotonic in each coordinate.
  bool misses(const model::Bounds4& bounds) const;

  /// Fails as Slicer::put does.
  Result<CutSlab> cut(const model::Slab& slab) const;
  /// Reads and cuts the blocks that the hyperplane meets, on all threads.
  Result<CutSlab> cut(const model::SlabBlocks& blocks) const;
  /// Computes the means of a run of cells only if the hyperplane may separate its other vertices.
  Result<CutSlab> cut(const model::LayeredSlab& slab) const;
  /// Calls one of the functions above. The slab must outlive its section.
  Result<CutSlab> cut(const OpenSlab& open) const;

 private:
  struct Heights {
    std::vector<double> heights;
    std::vector<std::uint8_t> sides;
  };
  double heightOf(const model::Point4& point) const;
  bool isAbove(double height) const;
  std::uint8_t sideOf(double height) const;
  Heights heightsOf(std::span<const model::Point4> vertices) const;
  double roundingOf(const model::LayeredSlab& slab) const;
  Cut cutRuns(const model::LayeredSlab& slab, const CellRuns& runs, Heights& of) const;
  template <class VertexAt>
  void place(const Cut& cut, VertexAt vertexAt, const std::vector<double>& heights,
             CutSlab& into) const;

  Hyperplane hyperplane_;
  HyperplaneBasis basis_;
  OnHyperplane rule_;
  std::shared_ptr<CutMemory> memory_;
  WithMotion withMotion_;
};

}  // namespace t4d::slice
