#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "formats/t4d/layout.h"
#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// The coding of the blocks of an array (SPEC.md, section "Arrays").
enum class Codec : std::uint8_t {
  Raw = 0,      ///< as they are
  Zstd = 1,     ///< one zstd frame of the transposed bytes
  Repeats = 2,  ///< one zstd frame of references to numbers shortly before, and the other numbers
};

/// Options of storing arrays.
struct ArrayOptions {
  int level = 3;                  ///< zstd level; 0 for none
  bool float32 = false;           ///< store positions as float32
  std::optional<Grid> grid = {};  ///< store positions as numbers on it

  bool round() const { return float32 || grid; }
};

/// Rows of `components` numbers of one type, row after row.
struct ArrayView {
  model::ScalarType type = model::ScalarType::Float64;
  std::uint8_t components = 1;
  std::span<const std::byte> bytes;
  bool isMany = false;  ///< large blocks are to be compressed in less time

  std::size_t rowBytes() const { return model::scalarSize(type) * components; }
};

template <class T>
ArrayView viewOf(const std::vector<T>& values) {
  return {model::scalarTypeOf<T>(), 1, std::as_bytes(std::span(values))};
}

/// Writes an array record and its blocks, compressed if that makes them smaller. Level 0 disables
/// compression. Blocks are distributed over threads.
void putArray(t4d_layout::PayloadWriter& into, const ArrayView& array, int level);

/// An array that is made block by block, so that it is never in memory whole.
struct MadeArray {
  model::ScalarType type = model::ScalarType::Float64;
  std::uint8_t components = 1;
  std::uint64_t rows = 0;
  /// Sets `into` to the rows of one block, from number `first` on. Called by several threads at
  /// once, and perhaps again for the same block.
  std::function<void(std::uint64_t first, std::span<std::byte> into)> make;
  bool isMany = false;  ///< large blocks are to be compressed in less time
};
void putArray(t4d_layout::PayloadWriter& into, const MadeArray& array, int level);

/// An array whose record has been checked, but whose blocks have not been unpacked.
struct PackedArray {
  model::ScalarType type = model::ScalarType::Float64;
  std::uint8_t components = 1;
  std::uint64_t rows = 0;
  Codec codec = Codec::Raw;
  /// Part of the payload it was read from.
  std::span<const std::span<const std::byte>> blocks;

  std::size_t rowBytes() const { return model::scalarSize(type) * components; }
};

/// Reads an array record. All its fields are checked against the blocks; errors describe the fault
/// and have no `where`. `features` are those named in the file.
Result<PackedArray> takePacked(t4d_layout::PayloadReader& from,
                               const t4d_layout::Features& features = {});

/// One block of the array; `into` has the size of its rows.
Result<void> unpackBlock(const PackedArray& array, std::size_t block, std::span<std::byte> into);

/// The array, row after row; blocks are distributed over threads.
Result<std::vector<std::byte>> unpack(const PackedArray& array);
/// Unpacks into memory of the array's size.
Result<void> unpack(const PackedArray& array, std::span<std::byte> into);

/// Checks that the array has this `type` and number of `components`.
Result<void> checkArray(const PackedArray& array, model::ScalarType type, std::uint8_t components);

struct Array {
  model::ScalarType type = model::ScalarType::Float64;
  std::uint8_t components = 1;
  std::uint64_t rows = 0;
  std::vector<std::byte> bytes;
};

/// takePacked and unpack.
Result<Array> takeArray(t4d_layout::PayloadReader& from, const t4d_layout::Features& features = {});

/// takeArray, and checkArray.
Result<Array> takeArrayOf(t4d_layout::PayloadReader& from, model::ScalarType type,
                          std::uint8_t components, const t4d_layout::Features& features = {});

}  // namespace t4d::formats
