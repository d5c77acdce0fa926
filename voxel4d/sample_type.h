#pragma once

#include <cstddef>
#include <cstdint>

namespace t4d::voxel4d {

/// The type of a sample in a file or an array.
enum class SampleType : std::uint8_t {
  Bool,
  Int8,
  UInt8,
  Int16,
  UInt16,
  Int32,
  UInt32,
  Int64,
  UInt64,
  Float32,
  Float64
};

constexpr std::size_t sizeOf(SampleType type) {
  switch (type) {
    case SampleType::Bool:
    case SampleType::Int8:
    case SampleType::UInt8:
      return 1;
    case SampleType::Int16:
    case SampleType::UInt16:
      return 2;
    case SampleType::Int32:
    case SampleType::UInt32:
    case SampleType::Float32:
      return 4;
    default:
      return 8;
  }
}

constexpr bool isInteger(SampleType type) {
  return type != SampleType::Bool && type != SampleType::Float32 && type != SampleType::Float64;
}

/// Whether float32 has all of its values.
constexpr bool fitsFloat32(SampleType type) {
  return isInteger(type) ? sizeOf(type) <= 2 : type == SampleType::Float32;
}

}  // namespace t4d::voxel4d
