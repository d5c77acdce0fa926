#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "conformance/corpus/cases.h"
#include "conformance/corpus/image.h"

/// Files with one fault each, grouped by section of SPEC.md.
namespace t4d::conformance {

/// A length that no file has.
inline constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();

/// A valid file to introduce faults into.
struct Base {
  Image image;
  std::vector<std::string> features;
};

/// `bodies` as a file.
Base baseOf(const std::vector<BodySlabs>& bodies, const ImageOptions& options = {});
/// A simplex in one slab: HEAD, CONN 0, SLAB 0, DONE, INDX.
Base plain();
/// plain() without an index.
Base unindexed();
/// A cross-polytope in two slabs: HEAD, CONN 0, LAYR 0, SLAB 0, CONN 1, SLAB 1, DONE, INDX.
Base layered();
/// A tetrahedron at rest from 0 to 1 in one slab: HEAD, CONN 0, LAYR 0, LAYR 1, SLAB 0, DONE, INDX.
Base between();
/// A tetrahedron at rest from 0 to 1, then moved up to 2: HEAD, CONN 0, LAYR 0, LAYR 1, POSE 0,
/// SLAB 0, POSE 1, SLAB 1, DONE, INDX. Only POSEs name LAYR 1.
Base withPoses();
/// A simplex plus two extra vertices, 5 and 6, and two means, 7 of four vertices and 8 of two.
model::Slab meansSlab();
/// layered() with two attributes for each vertex, "a" of type 1 and "b" of type 10.
Base withLayerAttributes();
/// meansSlab() as a file: HEAD, CONN 0, SLAB 0, DONE, INDX.
Base withMeans();
/// An optional chunk called "note" of type `note`.
Image::Chunk noteChunk(std::size_t bytes);

class InvalidCases {
 public:
  /// Adds `base`, modified by `change`. `name` begins with the number of the broken rule; the fault
  /// is at `at` bytes after the start of `place`.
  void add(const std::string& name, const std::string& fault, const Base& base,
           const std::function<void(Image&)>& change, const std::string& place, std::size_t at = 0);
  /// Adds `bytes`, with the fault at `offset`.
  void addBytes(const std::string& name, const std::string& fault, const Base& base,
                const std::string& bytes, std::uint64_t offset);
  /// Adds `base` with one bit flipped after everything else is computed.
  void addFlip(const std::string& name, const std::string& fault, const Base& base,
               const std::string& place, std::size_t at = 0);

  /// A slice of the last file at this time must be refused, too.
  void refusedAt(double time) { cases_.back().file.slices.push_back({time, {}, {}}); }

  std::vector<InvalidCase> finish() { return std::move(cases_); }

 private:
  std::vector<InvalidCase> cases_;
};

// H, O, C, F
void addFileHeaderFaults(InvalidCases& cases);
void addStructureFaults(InvalidCases& cases);
void addChunkFaults(InvalidCases& cases);
void addFooterFaults(InvalidCases& cases);
// Rules A and T.
void addArrayFaults(InvalidCases& cases);
void addAttributeFaults(InvalidCases& cases);
// Rules M.
void addHeadFaults(InvalidCases& cases);
// Rules N, L, K, S and P.
void addConnectivityFaults(InvalidCases& cases);
void addLayerFaults(InvalidCases& cases);
void addPoseFaults(InvalidCases& cases);
void addSlabFaults(InvalidCases& cases);
void addAssemblyFaults(InvalidCases& cases);
// Rules D and I.
void addDoneFaults(InvalidCases& cases);
void addIndexFaults(InvalidCases& cases);

/// Rules that are kept by halves: for some numbers of several, for some parts, just beyond a limit.
void addLimitFaults(InvalidCases& cases);

/// Byte sequences that are not UTF-8, each with its fault.
struct NotUtf8 {
  const char* name;
  const char* what;
  std::string bytes;
};
const std::vector<NotUtf8>& notUtf8();

}  // namespace t4d::conformance
