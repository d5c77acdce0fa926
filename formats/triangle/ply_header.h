#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/text/text_scanner.h"
#include "t4d/error.h"

namespace t4d::formats {

enum class PlyEncoding { Text, LittleEndian, BigEndian };

enum class PlyType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

/// Bytes of one number.
std::size_t plySize(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::Float32;  ///< of the number, or of a list's entries
  bool isList = false;
  PlyType countType = PlyType::UInt8;  ///< of a list's length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;  ///< as declared; not checked
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::Text;
  std::vector<PlyElement> elements;
};

/// Reads the header up to `end_header`; the scanner stops before the end of that line.
/// Fails on a header without vertices that have x, y and z, or without faces or triangle strips
/// that have a list of corners, and on one that declares one of these elements twice.
Result<PlyHeader> readPlyHeader(TextScanner& scanner);

}  // namespace t4d::formats
