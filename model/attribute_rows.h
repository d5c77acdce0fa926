#pragma once

#include <cstdint>
#include <span>

#include "t4d/mesh.h"

namespace t4d::model {

/// An attribute with these rows of the given one, in this order.
Attribute rowsOf(const Attribute& attribute, std::span<const std::uint32_t> rows);

/// Replaces each attribute of `domain` by rowsOf(attribute, rows). Attributes of the other domain
/// are not changed.
void selectRows(std::vector<Attribute>& attributes, Domain domain,
                std::span<const std::uint32_t> rows);

}  // namespace t4d::model
