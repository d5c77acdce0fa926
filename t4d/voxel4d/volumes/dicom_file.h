#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "t4d/model/error.h"
#include "t4d/voxel4d/sample_type.h"

namespace t4d::voxel4d {

/// How the samples of an image are stored.
struct DicomLayout {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::uint32_t bits = 0;    ///< of a sample in memory: 8, 16 or 32
  std::uint32_t stored = 0;  ///< its lowest bits that count
  bool isSigned = false;
  bool isFloat = false;
  bool bigEndian = false;
  std::string syntax;         ///< the UID of the transfer syntax
  bool encapsulated = false;  ///< compressed, in fragments

  std::uint64_t samples() const { return std::uint64_t{columns} * rows; }
  std::uint64_t bytes() const { return samples() * bits / 8; }
  SampleType type() const;
};

/// Bytes of a file, or of the deflated data set in it.
struct DicomPiece {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

/// What may say when an image was taken, in the order in which it is asked.
enum class DicomTime : std::uint8_t {
  Trigger,
  TemporalOffset,
  FrameReference,
  Acquisition,
  Content,
  TemporalPosition,  ///< a number only
};
inline constexpr std::size_t kDicomTimes = 6;

/// One plane of samples.
struct DicomImage {
  std::uint32_t file = 0;          ///< of a series
  std::uint64_t deflatedFrom = 0;  ///< the byte where a deflated data set begins; 0 if it is not
  std::vector<DicomPiece> pieces;
  double slope = 1;
  double intercept = 0;
  std::optional<Eigen::Vector3d> position;               ///< mm, LPS
  std::optional<std::array<double, 6>> orientation;      ///< of its rows and of its columns
  std::optional<std::array<double, 2>> spacing;          ///< mm: between rows, and between columns
  std::array<std::optional<double>, kDicomTimes> times;  ///< seconds
};

struct DicomFile {
  std::string series;  ///< SeriesInstanceUID
  std::string number;  ///< SeriesNumber
  std::string description;
  bool inverted = false;  ///< MONOCHROME1
  DicomLayout layout;
  std::vector<DicomImage> images;
  std::optional<Error> fault;  ///< why its images cannot be read, if they cannot
};

/// Whether a regular file has "DICM" at byte 128.
bool hasDicomSignature(const std::filesystem::path& path);

/// Reads everything but the samples. Fails for what is damaged. Images that are not planes of grey
/// integers, such as colours and films, and files without images are a `fault`.
Result<DicomFile> readDicomFile(const std::filesystem::path& path);

/// The bytes of an image of this file as they are stored.
Result<std::string> readDicomPieces(const std::filesystem::path& path, const DicomImage& image);

}  // namespace t4d::voxel4d
