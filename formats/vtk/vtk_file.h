#pragma once

#include <bit>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/input_file.h"
#include "formats/packed_block.h"
#include "t4d/mesh.h"

/// The XML of VTK's files, and their arrays as bytes. The readers know what the arrays mean.
namespace t4d::formats {

/// An array: where its values are. The file must outlive it.
struct VtkArray {
  std::string name;
  std::string type;    ///< "Float64", "UInt8", "String", ...
  std::string format;  ///< "appended", "binary" or "ascii"
  std::uint64_t components = 1;
  std::uint64_t offset = 0;  ///< of appended data
  std::string text;          ///< of the others
};

/// Cells: the arrays connectivity and offsets, and for an unstructured grid types.
struct VtkCells {
  std::uint64_t count = 0;
  std::vector<VtkArray> arrays = {};
};

struct VtkPiece {
  std::uint64_t points = 0;
  /// The point data that are normals and texture coordinates; empty if none are.
  std::string normals;
  std::string textureCoordinates;
  std::vector<VtkArray> pointData;
  std::vector<VtkArray> cellData;
  std::vector<VtkArray> coordinates;  ///< of `Points`, one
  VtkCells cells;                     ///< of an unstructured grid
  VtkCells vertices;                  ///< of polygonal data, as those that follow
  VtkCells lines;
  VtkCells strips;
  VtkCells polygons;
};

/// A file of a collection, as it is written there.
struct VtkDataSet {
  std::string timestep;
  std::string part;
  std::string file;
  std::uint64_t line = 0;
};

enum class VtkType : std::uint8_t {
  UnstructuredGrid,
  PolyData,
  Collection,
};

/// The array of this name; null if there is none.
const VtkArray* arrayNamed(const std::vector<VtkArray>& arrays, std::string_view name);

class VtkFile {
 public:
  /// Parses the XML. Fails if it is of another type or an unknown compressor.
  static Result<VtkFile> open(const InputFile& file, VtkType type);

  const std::vector<VtkPiece>& pieces() const { return pieces_; }
  const std::vector<VtkDataSet>& dataSets() const { return dataSets_; }
  const std::vector<VtkArray>& fieldData() const { return fieldData_; }
  /// "ASCII", "base64", "appended", "appended base64"; ", compressed with LZ4" and ", big-endian"
  /// where that is so.
  std::string dialect() const;

  // The values of an array, whatever their type. Memory is taken once the array is known to hold as
  // many; it fails if there are more or fewer, or if compressed arrays ask for far more memory than
  // the size of the file suggests.

  /// Sets those of `count` vertices, as many axes as the array has components, the first `axis`.
  template <class Point>
  Result<void> coordinates(const VtkArray& array, int axis, std::vector<Point>& into,
                           std::uint64_t count);
  Result<std::vector<std::int64_t>> integers(const VtkArray& array, std::uint64_t count);
  /// Integers from 0 to `limit` - 1; fails if one is not.
  Result<std::vector<std::uint32_t>> indices(const VtkArray& array, std::uint64_t count,
                                             std::uint32_t limit);
  /// Gives what `indices` gives, four for each cell.
  Result<std::vector<model::Cell>> tetrahedra(const VtkArray& array, std::uint64_t count,
                                              std::uint32_t limit);
  /// Integers from 0 to 255.
  Result<std::vector<std::uint8_t>> types(const VtkArray& array, std::uint64_t count);
  /// `count` rows, as they are.
  Result<model::Attribute> attribute(const VtkArray& array, model::Domain domain,
                                     std::uint64_t count);
  /// The bytes of strings, each with a 0 after it.
  Result<std::string> strings(const VtkArray& array);
  /// The type of an array; nothing if its values cannot be read.
  static std::optional<model::ScalarType> scalarTypeOf(const VtkArray& array);

  Error wrong(const VtkArray& array, const std::string& message) const;

 private:
  friend class VtkParser;
  /// A part of an array, compressed or not.
  struct Block {
    std::string_view packed;
    std::uint64_t begin;  ///< of its bytes in those of the array
    std::uint64_t size;   ///< unpacked
  };
  struct Blocks {
    Compressor compressor = Compressor::None;
    std::vector<Block> list;
    /// The bytes that the blocks refer to if it is not the file.
    std::unique_ptr<std::string> decoded = std::make_unique<std::string>();

    /// Adds bytes that are not compressed.
    void add(std::string_view bytes);
  };
  /// Takes the bytes that begin at `begin`.
  using TakeBytes = std::function<void(std::uint64_t begin, std::string_view bytes)>;

  /// The bytes of an array that is not ASCII: base64 text, or all that follows in appended data.
  Result<std::string_view> storedOf(const VtkArray& array) const;
  /// The size that the array states, in bytes.
  Result<std::uint64_t> sizeSaidBy(const VtkArray& array) const;
  Result<Blocks> blocksOf(const VtkArray& array, std::uint64_t size);
  /// Unpacks the blocks of an array on several threads.
  Result<void> unpack(const VtkArray& array, const Blocks& blocks, const TakeBytes& take) const;
  /// Calls `makePut(first)(number)` with each value from number `first` on, on several threads;
  /// text is read as `Text`.
  template <class Text, class Allocate, class MakePut>
  Result<void> forValues(const VtkArray& array, std::uint64_t count, Allocate allocate,
                         MakePut makePut);
  /// `allocate` returns where the indices go.
  template <class Index, class Allocate>
  Result<void> indicesBelow(const VtkArray& array, std::uint64_t count, std::uint64_t limit,
                            Allocate allocate);

  const InputFile* file_ = nullptr;
  std::vector<VtkPiece> pieces_;
  std::vector<VtkDataSet> dataSets_;
  std::vector<VtkArray> fieldData_;
  Compressor compressor_ = Compressor::None;
  std::endian order_ = std::endian::little;
  bool wideHeader_ = false;  // sizes of 64 bits
  bool rawAppended_ = true;
  std::string_view appended_;
  std::uint64_t unpacked_ = 0;  // bytes of compressed arrays so far
};

}  // namespace t4d::formats
