#pragma once

#include <cstdint>
#include <span>

#include "t4d/model/attribute.h"

namespace t4d::model {

/// An attribute with these rows of the given one, in this order.
Attribute rowsOf(const Attribute& attribute, std::span<const std::uint32_t> rows);

/// The same of each attribute of a domain; the others stay as they are.
void selectRows(std::vector<Attribute>& attributes, Domain domain,
                std::span<const std::uint32_t> rows);

}  // namespace t4d::model
