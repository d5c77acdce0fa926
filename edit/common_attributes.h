#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::edit {

/// Finds the attributes that every slab of a mesh has.
class CommonAttributes : public model::Sink {
 public:
  Result<void> put(const model::Slab& slab) override;

  /// The attributes that all slabs have, without rows.
  const std::vector<model::Attribute>& attributes() const { return common_; }
  /// The names of attributes that only some slabs have.
  const std::set<std::string>& others() const { return others_; }

 private:
  bool isFirst_ = true;
  std::vector<model::Attribute> common_;
  std::set<std::string> others_;
};

/// The slab with these attributes only.
std::shared_ptr<const model::Slab> withOnly(const std::vector<model::Attribute>& wanted,
                                            const std::shared_ptr<const model::Slab>& slab);

}  // namespace t4d::edit
