#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// Amounts as a reader likes them, in messages.
namespace t4d::model {

/// "1,234,567".
std::string grouped(std::uint64_t number);

/// "1 slab", "2,000 slabs". `many` is the plural, by default `one` with an s.
std::string counted(std::uint64_t number, std::string_view one, std::string_view many = {});

/// "12.3 MB".
std::string sizeText(std::uint64_t bytes);

}  // namespace t4d::model
