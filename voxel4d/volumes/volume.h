#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"
#include "voxel4d/sample_type.h"

namespace t4d::voxel4d {

enum class SampleEncoding : std::uint8_t { Raw, Gzip, Text, Stream };

class SampleReader;

/// The place of samples.
struct SampleData {
  std::filesystem::path path;
  std::uint64_t offset = 0;  ///< of the data in the file, as they are stored
  std::uint64_t begin = 0;   ///< of the samples in the data, unpacked
  SampleEncoding encoding = SampleEncoding::Raw;
  bool mayHaveMore = false;                   ///< bytes may follow the samples
  std::shared_ptr<SampleReader> stream = {};  ///< of a stream: frame after frame, once
};

/// An axis of which not all samples are read.
struct StoredAxis {
  std::uint64_t size = 0;   ///< samples in the file
  std::uint64_t first = 0;  ///< the first that is read
};

/// The contents of the header of a file of samples: one frame or several, on one lattice.
struct Volume {
  std::string where;  ///< for errors: the file with the header

  SampleType type = SampleType::Float32;
  std::endian order = std::endian::little;
  double slope = 1;  ///< the value of a sample is slope * sample + intercept
  double intercept = 0;

  /// Samples along each axis of the data, the one that varies fastest first, and what each is: x,
  /// y, z or t.
  std::vector<std::uint64_t> sizes;
  std::string axes;
  /// The axes of the stored data if only a region of it, `sizes`, is read. Else empty.
  std::vector<StoredAxis> stored = {};

  /// Maps (i, j, k), numbers of a sample along x, y and z, to a position.
  model::Affine3x4 place = model::Affine3x4::Identity();
  /// What positions are relative to a patient, "RAS" (x to the right, y anterior, z superior) or
  /// "LPS"; "" if that is not said.
  std::string space;
  std::string notice;  ///< what was changed while the header was read; "" for nothing
  /// Axes along which nothing says how large a voxel is, so that it is taken as 1: "xyz".
  std::string unsized;
  /// The axes of the data in the order in which they are taken, as "txyz", if nothing names them.
  std::string assumedAxes;

  std::optional<double> frameTime;
  double startTime = 0;
  std::vector<double> times;  ///< of each frame, if they are not evenly apart; else empty
  std::string lengthUnit;
  std::string timeUnit;

  bool mask = false;                    ///< samples of a byte are 0 outside
  std::vector<std::string> frameNames;  ///< for errors about a frame; empty for its number
  std::string name;                     ///< of the data, if `where` does not have it
  std::vector<std::string> notes;       ///< what was assumed when the data were read
  std::vector<std::string> losses;      ///< what was left out then

  /// One for all, or one for each frame that is read.
  std::vector<SampleData> data;

  /// Samples along 'x', 'y', 'z' or 't'; 1 along an axis that is not there.
  std::uint64_t size(char axis) const {
    const auto at = axes.find(axis);
    return at == std::string::npos ? 1 : sizes[at];
  }
  std::uint64_t frames() const { return size('t'); }
  /// The number in the file of the first sample that is read.
  std::uint64_t first(char axis) const {
    const auto at = axes.find(axis);
    return at == std::string::npos || stored.empty() ? 0 : stored[at].first;
  }
};

}  // namespace t4d::voxel4d
