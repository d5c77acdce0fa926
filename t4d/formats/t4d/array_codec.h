#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/t4d/layout.h"
#include "t4d/model/attribute.h"
#include "t4d/model/error.h"

namespace t4d::formats {

/// How the bytes of an array are stored.
enum class Codec : std::uint8_t {
  Raw = 0,   ///< as they are
  Zstd = 1,  ///< one zstd frame of the transposed bytes
};

/// Rows of `components` numbers of one type, row after row.
struct ArrayView {
  model::ScalarType type = model::ScalarType::Float64;
  std::uint8_t components = 1;
  std::span<const std::byte> bytes;

  std::size_t rowBytes() const { return model::scalarSize(type) * components; }
};

template <class T>
ArrayView viewOf(const std::vector<T>& values) {
  return {model::scalarTypeOf<T>(), 1, std::as_bytes(std::span(values))};
}

/// Writes an array record (SPEC.md, section "Arrays"), compressed where that makes it smaller. A
/// `level` of 0 compresses nothing.
///
/// Before compression the bytes are transposed: first the first byte of every row, then the second
/// of every row, and so on. Bytes that vary little, signs and exponents say, so come together.
void putArray(t4d_layout::ByteWriter& into, const ArrayView& array, int level);

/// An array record that has been judged but not unpacked.
struct PackedArray {
  model::ScalarType type = model::ScalarType::Float64;
  std::uint8_t components = 1;
  std::uint64_t rows = 0;
  Codec codec = Codec::Raw;
  std::span<const std::byte> stored;  ///< in the payload it was taken from

  std::size_t rowBytes() const { return model::scalarSize(type) * components; }
};

/// Takes an array record. Everything that it claims is held against what is stored; errors say the
/// fault and have no `where`. `features` are those that the file names.
Result<PackedArray> takePacked(t4d_layout::ByteReader& from, t4d_layout::Features features = {});

/// The array, row after row. While it works it needs twice the array in memory.
Result<std::vector<std::byte>> unpack(const PackedArray& array);

struct Array {
  model::ScalarType type = model::ScalarType::Float64;
  std::uint8_t components = 1;
  std::uint64_t rows = 0;
  std::vector<std::byte> bytes;
};

/// takePacked and unpack.
Result<Array> takeArray(t4d_layout::ByteReader& from, t4d_layout::Features features = {});

/// takeArray, and what it must be: `type`, `components`.
Result<Array> takeArrayOf(t4d_layout::ByteReader& from, model::ScalarType type,
                          std::uint8_t components, t4d_layout::Features features = {});

}  // namespace t4d::formats
