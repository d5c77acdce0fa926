#include "edit/common_attributes.h"

#include <algorithm>

namespace t4d::edit {
namespace {

using model::Attribute;

/// Whether there is one that is the same but for its values.
bool has(const std::vector<Attribute>& some, const Attribute& wanted) {
  return std::ranges::any_of(some, [&](const Attribute& one) {
    return one.name == wanted.name && one.domain == wanted.domain && one.type == wanted.type &&
           one.components == wanted.components;
  });
}

}  // namespace

Result<void> CommonAttributes::put(const model::Slab& slab) {
  std::vector<Attribute> its;
  for (const auto* some : {&slab.connectivity->cellAttributes, &slab.attributes}) {
    for (const Attribute& one : *some) {
      its.push_back({one.name, one.domain, one.type, one.components, {}});
    }
  }
  if (isFirst_) common_ = its;
  isFirst_ = false;
  std::erase_if(common_, [&](const Attribute& one) {
    if (has(its, one)) return false;
    others_.insert(one.name);
    return true;
  });
  for (const Attribute& one : its) {
    if (!has(common_, one)) others_.insert(one.name);
  }
  return {};
}

std::shared_ptr<const model::Slab> withOnly(const std::vector<Attribute>& wanted,
                                            const std::shared_ptr<const model::Slab>& slab) {
  const auto isUnwanted = [&](const Attribute& one) { return !has(wanted, one); };
  if (std::ranges::none_of(slab->attributes, isUnwanted) &&
      std::ranges::none_of(slab->connectivity->cellAttributes, isUnwanted)) {
    return slab;
  }
  auto kept = std::make_shared<model::Slab>(*slab);
  auto connectivity = std::make_shared<model::Connectivity>(*slab->connectivity);
  std::erase_if(kept->attributes, isUnwanted);
  std::erase_if(connectivity->cellAttributes, isUnwanted);
  kept->connectivity = std::move(connectivity);
  return kept;
}

}  // namespace t4d::edit
