#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "formats/t4d/array_codec.h"
#include "formats/t4d/layout.h"
#include "t4d/mesh.h"

/// Payloads of chunks with named fields, so that a single field can be corrupted.
namespace t4d::conformance {

/// The little-endian bytes of a number.
template <class T>
std::string bytesOf(T value) {
  static_assert(std::is_arithmetic_v<T>);
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// A sequence of fields with named places, and the blocks of the arrays among them.
class Record {
 public:
  struct Place {
    std::size_t offset = 0;
    std::size_t size = 0;
  };
  struct Block {
    std::string name;
    std::string bytes;
  };

  template <class T>
  void put(const std::string& field, T value) {
    putBytes(field, bytesOf(value));
  }
  void putBytes(const std::string& field, std::string_view bytes);
  void putBlock(const std::string& name, std::string_view bytes);
  /// Appends zeros up to a multiple of 8.
  void pad(const std::string& field = "padding");
  /// Appends another record; its fields and blocks are renamed to PREFIX/FIELD. It must begin at a
  /// multiple of 8.
  void add(const std::string& prefix, const Record& record);

  /// The bytes of the fields, without blocks.
  const std::string& bytes() const { return bytes_; }
  std::size_t size() const { return bytes_.size(); }
  const std::vector<Block>& blocks() const { return blocks_; }
  bool has(const std::string& field) const { return fields_.contains(field) || hasBlock(field); }
  bool hasBlock(const std::string& name) const;
  /// The place of a field. Throws std::out_of_range for an unknown name, which is a mistake in the
  /// corpus.
  Place place(const std::string& field) const;
  /// The bytes of a field or block.
  std::string contents(const std::string& name) const;
  /// Overwrites bytes from byte `at` of the field or block.
  void overwrite(const std::string& field, std::string_view bytes, std::size_t at = 0);
  /// A copy of the record that was added as `prefix`.
  Record part(const std::string& prefix) const;
  /// Replaces the record that was added as `prefix`; the bytes and blocks after it move.
  void replace(const std::string& prefix, const Record& record);
  void truncate(std::size_t size) { bytes_.resize(size); }
  void dropBlocks() { blocks_.clear(); }
  template <class T>
  T get(const std::string& field) const {
    T value{};
    bytes_.copy(reinterpret_cast<char*>(&value), sizeof value, place(field).offset);
    return value;
  }
  /// The payload of a chunk: the table of blocks with the fields "NAME size" and "NAME checksum",
  /// the fields, and the blocks, each with its padding, "NAME padding". It has no blocks of its
  /// own.
  Record asPayload() const;
  /// The size of the payload before its blocks.
  std::size_t frontSize() const;

 private:
  std::string bytes_;
  std::map<std::string, Place> fields_;
  std::vector<Block> blocks_;
};

/// The storage of the arrays of a file.
enum class Storage : std::uint8_t {
  Raw,
  Blocks,   ///< codec 1: hand-made zstd frames of stored blocks
  Library,  ///< codec 1: zstd frames made by the library
  Repeats,  ///< codec 2 where it is possible, else 1: zstd frames made by the library
};

/// An array record with these fields, consistent or not. Fields: "scalar type", "components",
/// "codec", "reserved", "rows"; blocks: "stored", "stored 1", ...
Record arrayRecord(std::uint8_t scalarType, std::uint8_t components, std::uint8_t codec,
                   std::uint64_t rows, const std::vector<std::string>& blocks);

/// A valid record of an array given row after row.
Record arrayRecord(model::ScalarType type, std::uint8_t components, std::string_view bytes,
                   Storage storage);

/// Transposes rows: the first byte of all rows, then the second byte of all rows, and so on.
std::string transposed(std::string_view bytes, std::size_t rowBytes);

/// The content of a frame of codec 2, for rows of `components` numbers of four bytes.
std::string repeats(std::string_view bytes, std::size_t components);

/// Fields: "domain", "reserved", "name length", "name", "name padding", "values/...".
Record attributeRecord(const model::Attribute& attribute, Storage storage);

/// Fields as in the table of SPEC.md, then "cells/...", "mean sizes/...", "mean sources/...",
/// "attribute 0/...".
Record connectivityRecord(const model::Connectivity& connectivity, Storage storage);

/// Fields: "time", "attributes", "reserved", "positions/...", "attribute 0/...".
Record layerRecord(double time, std::span<const model::Point4> vertices,
                   std::span<const model::Attribute> attributes,
                   const formats::ArrayOptions& positions, Storage storage);

/// Fields: "time", "layer", "m00" to "m23". The distance is 0.
Record poseRecord(double time, const model::Affine3x4& pose);

/// Fields as in the table of SPEC.md, then "interior positions/...", "interior times/...",
/// "attribute 0/...". Distances are 0.
Record slabRecord(const model::TimeSpan& time, std::uint32_t body,
                  const std::vector<model::Bounds4>& bounds,
                  std::span<const model::Point4> interior,
                  std::span<const model::Attribute> attributes,
                  const formats::ArrayOptions& positions, Storage storage);

}  // namespace t4d::conformance
