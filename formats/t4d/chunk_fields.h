#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "formats/t4d/array_codec.h"
#include "formats/t4d/layout.h"
#include "t4d/error.h"
#include "t4d/mesh.h"

/// Fields that chunks of several types have (SPEC.md).
namespace t4d::formats {

Error cutOff(const char* what);

/// Fails if fields or blocks are left.
Result<void> checkEnd(const t4d_layout::PayloadReader& from);

void putTime(t4d_layout::ByteWriter& into, const model::TimeSpan& time);
model::TimeSpan takeTime(t4d_layout::ByteReader& from);
Result<void> checkTime(const model::TimeSpan& time);

/// Sets `into` to vertices from number `first` on; called by several threads at once.
using VertexMaker = std::function<void(std::uint64_t first, std::span<model::Point4> into)>;

void putPositions(t4d_layout::PayloadWriter& into, std::uint64_t count, const VertexMaker& vertices,
                  const ArrayOptions& options);
/// The fourth coordinate of each vertex.
void putTimes(t4d_layout::PayloadWriter& into, std::uint64_t count, const VertexMaker& vertices,
              int level);
Result<PackedArray> takePositions(t4d_layout::PayloadReader& from,
                                  const t4d_layout::Features& features);
/// Unpacks all positions; `into` has a vertex for each row. Leaves its times unchanged.
Result<void> unpackPositions(const PackedArray& array, std::span<model::Point4> into,
                             const t4d_layout::Features& features);
/// Unpacks the positions of one block of the array; `into` has a vertex for each of its rows.
Result<void> unpackPositions(const PackedArray& array, std::size_t block,
                             std::span<model::Point4> into, const t4d_layout::Features& features);

void putAttribute(t4d_layout::PayloadWriter& into, const model::Attribute& attribute, int level);
Result<std::vector<model::Attribute>> takeAttributes(t4d_layout::PayloadReader& from,
                                                     std::uint32_t count,
                                                     const t4d_layout::Features& features);

}  // namespace t4d::formats
