#include "measure/contact_stretches.h"

#include <algorithm>
#include <array>
#include <utility>

namespace t4d::measure {
namespace {

/// Ties are broken by the cells, so that the result does not depend on who comes first.
std::array<std::uint64_t, 4> orderOf(const Contact& contact) {
  constexpr CellNumber kNone = {~std::uint64_t{0}, ~std::uint64_t{0}};
  const CellNumber a = contact.a.value_or(kNone);
  const CellNumber b = contact.b.value_or(kNone);
  return {a.slab, a.cell, b.slab, b.cell};
}

/// The longer one, or the one that comes first.
model::TimeSpan longer(const model::TimeSpan& p, const model::TimeSpan& q) {
  const double ofP = p.end - p.begin;
  const double ofQ = q.end - q.begin;
  if (ofP != ofQ) return ofP > ofQ ? p : q;
  return std::pair(p.begin, p.end) < std::pair(q.begin, q.end) ? p : q;
}

}  // namespace

void ContactStretches::add(const ContactStretch& stretch) {
  ContactStretch united = stretch;
  const auto from = std::ranges::lower_bound(all_, stretch.begin, {}, &ContactStretch::end);
  auto to = from;
  for (; to != all_.end() && to->begin <= stretch.end; ++to) {
    if (to->begin < united.begin ||
        (to->begin == united.begin && orderOf(to->first) < orderOf(united.first))) {
      united.begin = to->begin;
      united.first = to->first;
      united.beginKnown = to->beginKnown;
    }
    if (to->end > united.end ||
        (to->end == united.end && orderOf(to->last) < orderOf(united.last))) {
      united.end = to->end;
      united.last = to->last;
      united.endKnown = to->endKnown;
    }
    united.overlaps = united.overlaps || to->overlaps;
    united.crossing = longer(united.crossing, to->crossing);
  }
  if (from == to) {
    all_.insert(from, united);
    return;
  }
  *from = united;
  all_.erase(from + 1, to);
}

bool ContactStretches::covers(double begin, double end) const {
  const auto found = std::ranges::lower_bound(all_, end, {}, &ContactStretch::end);
  return found != all_.end() && found->overlaps && found->begin <= begin;
}

bool ContactStretches::includes(double begin, double end) const {
  const auto found = std::ranges::lower_bound(all_, end, {}, &ContactStretch::end);
  return found != all_.end() && found->begin <= begin;
}

}  // namespace t4d::measure
