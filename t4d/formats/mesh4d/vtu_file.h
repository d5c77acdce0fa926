#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "t4d/formats/input_file.h"
#include "t4d/formats/packed_block.h"

/// The XML of a .vtu file, and its arrays as bytes. What the arrays mean is vtu_reader.cpp's.
namespace t4d::formats {

/// An array: where its values are. The file must outlive it.
struct VtuArray {
  std::string name;
  std::string type;    ///< "Float64", "UInt8", "String", ...
  std::string format;  ///< "appended", "binary" or "ascii"
  std::uint64_t components = 1;
  std::uint64_t offset = 0;  ///< of appended data
  std::string text;          ///< of the others
};

struct VtuPiece {
  std::uint64_t points = 0;
  std::uint64_t cells = 0;
  std::vector<VtuArray> pointData;
  std::vector<VtuArray> cellData;
  std::vector<VtuArray> coordinates;   ///< of `Points`, one
  std::vector<VtuArray> connectivity;  ///< of `Cells`: connectivity, offsets, types
};

class VtuFile {
 public:
  /// Parses the XML. Fails if it is not that of an unstructured grid, or of an unknown compressor.
  static Result<VtuFile> open(const InputFile& file);

  const std::vector<VtuPiece>& pieces() const { return pieces_; }
  const std::vector<VtuArray>& fieldData() const { return fieldData_; }
  /// "ASCII", "base64", "appended", "appended base64"; ", compressed with LZ4" and ", big-endian"
  /// where that is so.
  std::string dialect() const;

  /// The values of an array with so many, as doubles or as integers; whatever their type. Fails if
  /// there are more or fewer.
  Result<std::vector<double>> numbers(const VtuArray& array, std::uint64_t count) const;
  Result<std::vector<std::int64_t>> integers(const VtuArray& array, std::uint64_t count) const;
  /// Likewise integers from 0 to `limit` - 1; fails if one is not.
  Result<std::vector<std::uint32_t>> indices(const VtuArray& array, std::uint64_t count,
                                             std::uint32_t limit) const;

  tl::unexpected<Error> wrong(const VtuArray& array, const std::string& message) const;

 private:
  friend class VtuParser;
  /// `Number` is made of a stored number by `make`.
  template <class Number, class Make>
  Result<std::vector<Number>> values(const VtuArray& array, std::uint64_t count, Make make) const;
  Result<std::string> bytesOf(const VtuArray& array, std::uint64_t size) const;

  const InputFile* file_ = nullptr;
  std::vector<VtuPiece> pieces_;
  std::vector<VtuArray> fieldData_;
  Compressor compressor_ = Compressor::None;
  std::endian order_ = std::endian::little;
  bool wideHeader_ = false;  // sizes of 64 bits
  bool rawAppended_ = true;
  std::string_view appended_;
};

}  // namespace t4d::formats
