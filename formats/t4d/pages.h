#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "formats/t4d/chunk_file.h"
#include "formats/t4d/index_chunk.h"
#include "t4d/file.h"

/// PAGE and PGIX: the index again in pages, with encoders and decoders side by side (SPEC.md,
/// section "PAGE and PGIX").
namespace t4d::formats {

/// Files with fewer slabs than this many pages have none.
inline constexpr std::size_t kLeastPages = 8;
inline constexpr std::size_t kUsualPageSlabs = 2048;
/// PGIX has an entry for each body in each page.
inline constexpr std::size_t kMostPagedBodies = 64;

/// The share of a body that a page has.
struct PageBody {
  std::uint32_t body = 0;
  std::uint32_t slabs = 0;
  model::TimeSpan time;
  model::Bounds3 bounds;
};

/// The entry of a page in PGIX.
struct PageEntry {
  std::uint64_t offset = 0;    ///< of the PAGE
  std::uint32_t checksum = 0;  ///< of its header
  std::vector<PageBody> bodies;
};

struct PageList {
  ChunkHeader head;               ///< of HEAD
  std::vector<T4dChunks> chunks;  ///< those before PGIX
  std::vector<PageEntry> pages;
  std::uint64_t offset = 0;  ///< of PGIX
};

/// A page: chunks that follow one another, those before that they may name, and the slabs.
struct Page {
  std::vector<ChunkHeader> chunks;  ///< in the order of the file
  std::vector<IndexRecord> slabs;   ///< each has an extent
};

/// A run of the chunks of a file, and its slabs.
struct PageRun {
  std::vector<ChunkHeader> earlier;  ///< that they may name
  std::vector<ChunkHeader> chunks;
  std::vector<IndexRecord> slabs;
};

/// Calls `use` with the runs of all chunks after HEAD, of `pageSlabs` slabs each, up to the first
/// error; not at all if the file is to have no pages. `use` may add to `chunks`, of which HEAD is
/// the first.
Result<void> eachPageRun(const ChunkList& chunks, const SlabList& slabs, std::size_t bodyCount,
                         std::size_t pageSlabs,
                         const std::function<Result<void>(const PageRun& run)>& use);

/// The PAGE of a run, to be written at `offset`, and its entry without the checksum.
t4d_layout::PayloadWriter encodePage(const PageRun& run, std::uint64_t offset, int level);
PageEntry entryOf(const PageRun& run, std::uint64_t offset);

t4d_layout::PayloadWriter encodePageList(const PageList& list);

/// The PGIX before the DONE at `done`, whose bodies have these summaries; none if there is none.
/// Fails if it is damaged or contradicts DONE.
Result<std::optional<PageList>> readPageList(const ChunkFile& file, std::uint64_t done,
                                             const std::vector<BodySummary>& bodies);

/// A page of the list; fails if it is damaged or says something else than the list.
Result<Page> readPage(const ChunkFile& file, const PageList& list, std::size_t number,
                      const t4d_layout::Features& features);

/// The slabs as the pages have them, with extents, after checking that `chunks` (without HEAD) and
/// `slabs` of the file are in these pages and no others.
Result<SlabList> checkPages(const ChunkFile& file, const PageList& list, const ChunkList& chunks,
                            const SlabList& slabs, const t4d_layout::Features& features);

}  // namespace t4d::formats
