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

/// Writes an array record (SPEC.md, section "Arrays"), compressed if that makes it smaller. Level 0
/// disables compression.
///
/// Bytes are transposed before compression: the first byte of every row, then the second byte of
/// every row, and so on. This groups bytes that vary little, such as signs and exponents.
void putArray(t4d_layout::ByteWriter& into, const ArrayView& array, int level);

/// An array record that has been checked but not unpacked.
struct PackedArray {
  model::ScalarType type = model::ScalarType::Float64;
  std::uint8_t components = 1;
  std::uint64_t rows = 0;
  Codec codec = Codec::Raw;
  std::span<const std::byte> stored;  ///< part of the payload it was read from

  std::size_t rowBytes() const { return model::scalarSize(type) * components; }
};

/// Reads an array record. All its fields are checked against the stored bytes; errors describe the
/// fault and have no `where`. `features` are those named in the file.
Result<PackedArray> takePacked(t4d_layout::ByteReader& from, t4d_layout::Features features = {});

/// The array, row after row. Uses twice the size of the array while it works.
Result<std::vector<std::byte>> unpack(const PackedArray& array);

struct Array {
  model::ScalarType type = model::ScalarType::Float64;
  std::uint8_t components = 1;
  std::uint64_t rows = 0;
  std::vector<std::byte> bytes;
};

/// takePacked and unpack.
Result<Array> takeArray(t4d_layout::ByteReader& from, t4d_layout::Features features = {});

/// takeArray, and checks that the result has this `type` and number of `components`.
Result<Array> takeArrayOf(t4d_layout::ByteReader& from, model::ScalarType type,
                          std::uint8_t components, t4d_layout::Features features = {});

}  // namespace t4d::formats
