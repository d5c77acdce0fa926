#include "formats/t4d/found_chunks.h"

#include <algorithm>
#include <set>
#include <tuple>

namespace t4d::formats {

namespace {

/// The fields that identify a slab wherever it is.
auto identityOf(const IndexRecord& record, std::uint32_t frontCrc) {
  return std::tuple(frontCrc, record.parts.body, record.time.begin, record.time.end,
                    record.parts.connectivity, record.parts.lower, record.parts.upper,
                    record.slabBytes);
}
using Identity = decltype(identityOf({}, 0));

/// Identity of each slab listed in the index.
std::vector<Identity> identitiesOf(const Index& index) {
  std::vector<Identity> identities;
  for (const ChunkHeader& chunk : index.chunks) {
    if (chunk.type != t4d_layout::kSlab) continue;
    identities.push_back(identityOf(index.slabs[identities.size()], chunk.frontCrc));
  }
  return identities;
}

/// An empty slab, which may legitimately occur twice in a row.
bool mayRepeat(const IndexRecord& record) {
  return record.parts.lower == 0 && record.parts.upper == 0 && record.time.begin == record.time.end;
}

}  // namespace

void FoundChunks::compareWith(const Index& index) {
  match(index);
  const bool moved = std::any_of(found_.begin(), found_.end(), [](const Slab& slab) {
    return slab.before && *slab.before != slab.record.slab;
  });
  if (moved) {
    placeMovedParts(index);
  } else {
    for (const Part& part : parts_) place(part.header, part.header.offset, index);
  }
  for (const Slab& slab : found_) {
    if (slab.again || (!index.chunks.empty() && !slab.before)) continue;
    slabs_.push_back({slab.record, slab.before.value_or(slab.record.slab)});
  }
  std::stable_sort(slabs_.begin(), slabs_.end(),
                   [](const auto& a, const auto& b) { return a.before < b.before; });
  // A missing slab would have moved as far as the one before it.
  for (FoundSlab& slab : missing_) {
    const auto next =
        std::upper_bound(slabs_.begin(), slabs_.end(), slab.before,
                         [](std::uint64_t at, const auto& other) { return at < other.before; });
    if (next == slabs_.begin()) continue;
    const FoundSlab& neighbour = *(next - 1);
    slab.record.slab = slab.before + (neighbour.record.slab - neighbour.before);
  }
}

/// The index record of each slab.
void FoundChunks::match(const Index& index) {
  const std::vector<Identity> identities = identitiesOf(index);
  std::set<std::pair<Identity, std::uint64_t>> open;
  for (std::size_t i = 0; i < identities.size(); ++i) {
    open.emplace(identities[i], index.slabs[i].slab);
  }
  std::map<Identity, std::uint64_t> taken;
  std::uint64_t shift = 0;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    Slab& slab = found_[i];
    const Identity identity = identityOf(slab.record, slab.frontCrc);
    // Empty slabs may be equal: take the one at the expected offset, or else the first.
    auto record = open.find({identity, slab.record.slab - shift});
    if (record == open.end()) record = open.lower_bound({identity, 0});
    if (record != open.end() && record->first == identity) {
      slab.before = record->second;
      taken.emplace(identity, record->second);
      open.erase(record);
    } else if (index.chunks.empty()) {
      slab.again =
          i >= slabsBeforeEnd_ || (!taken.emplace(identity, 0).second && !mayRepeat(slab.record));
      continue;
    } else if (const auto first = taken.find(identity); first != taken.end()) {
      slab.before = first->second;
      slab.again = true;
    } else {
      continue;
    }
    shift = slab.record.slab - *slab.before;
  }
  for (std::size_t i = 0; i < identities.size(); ++i) {
    const IndexRecord& record = index.slabs[i];
    if (open.contains({identities[i], record.slab})) missing_.push_back({record, record.slab});
  }
}

void FoundChunks::placeMovedParts(const Index& index) {
  struct Neighbour {
    std::uint64_t run = 0;
    std::optional<std::uint64_t> shift = 0;
  } last;  // initially the beginning of the file
  auto part = parts_.begin();
  for (const Slab& slab : found_) {
    Neighbour next{slab.run, std::nullopt};
    if (slab.before) next.shift = slab.record.slab - *slab.before;
    for (; part != parts_.begin() + static_cast<std::ptrdiff_t>(slab.partsBefore); ++part) {
      const bool ofLast = part->run == last.run;
      const bool ofNext = part->run == next.run;
      if (last.shift != next.shift && ofLast == ofNext) continue;
      const auto shift = ofLast ? last.shift : next.shift;
      if (shift) place(part->header, part->header.offset - *shift, index);
    }
    last = next;
  }
}

void FoundChunks::place(const ChunkHeader& part, std::uint64_t before, const Index& index) {
  ChunkHeader original = part;
  original.offset = before;
  const auto said = std::ranges::lower_bound(index.chunks, before, {}, &ChunkHeader::offset);
  const bool isOfFile = said != index.chunks.end() && *said == original;
  if (!isOfFile && !index.chunks.empty()) return;
  if (now_.emplace(before, part.offset).second) before_.emplace(part.offset, before);
}

std::optional<std::uint64_t> FoundChunks::part(std::uint64_t before) const {
  const auto found = now_.find(before);
  return found == now_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace t4d::formats
