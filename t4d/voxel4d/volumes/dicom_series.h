#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "t4d/model/error.h"
#include "t4d/voxel4d/volumes/dicom_file.h"
#include "t4d/voxel4d/volumes/sample_reader.h"
#include "t4d/voxel4d/volumes/volume.h"

namespace t4d::voxel4d {

/// The planes of a series, frame after frame, each in the order of their positions.
struct DicomPlanes {
  std::vector<std::filesystem::path> files;
  DicomLayout layout;
  std::vector<DicomImage> images;
  bool scaled = false;  ///< to floats, each by its own slope and intercept
};

/// Whether it is a file with DICOM's signature, or a folder that holds one and no .vdb file.
bool isDicom(const std::filesystem::path& path);

/// One series of DICOM images as one volume over time. `inputs` are files, or folders whose files
/// with the signature are taken, except DICOMDIR. `series` chooses among several: a
/// SeriesInstanceUID or a SeriesNumber.
///
/// Images are sorted by their place along the normal of their planes, and at each place by time: by
/// the first of DicomTime that all images have and that makes frames of them. A frame has one image
/// of each place, and images of a frame are nearer in time than frames are.
Result<Volume> readDicomSeries(std::span<const std::filesystem::path> inputs,
                               const std::string& series);

/// Reads the samples of all planes one after another.
std::unique_ptr<SampleReader> openDicomSamples(std::shared_ptr<const DicomPlanes> planes);

}  // namespace t4d::voxel4d
