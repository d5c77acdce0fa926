#pragma once

#include <filesystem>
#include <string_view>

#include "t4d/error.h"
#include "voxel4d/volumes/volume.h"

namespace t4d::voxel4d {

/// NRRD (teem.sourceforge.net/nrrd/format.html): .nrrd, or .nhdr with its data in other files of
/// the same folder or below: one, a list, or a numbered series of a frame each. Encodings raw, gzip
/// and text. Axes are of space but for at most one, which is time: that of kind `time` or `list`,
/// with the direction `none`, or along the fourth dimension of space; of four axes without kinds
/// and directions the last. The times of frames are their index values in a sequence of 3D Slicer.
Result<Volume> readNrrdHeader(const std::filesystem::path& path);

/// NIfTI-1 and -2 (nifti.nimh.nih.gov): .nii, .nii.gz, or .hdr with .img or .img.gz. Positions are
/// those of its sform, or qform, or multiples of its voxel size, in this order.
Result<Volume> readNiftiHeader(const std::filesystem::path& path);

/// NumPy's .npy, versions 1 to 3. `axes` says what its axes are, as `txyz`; empty: `txyz` of four
/// axes, `xyz` of three.
Result<Volume> readNpyHeader(const std::filesystem::path& path, std::string_view axes);

/// Bare samples after a line of text, `raw TYPE NX NY NZ [NT] [little|big]`, or all of a file
/// without one whose line is given; where both are there, they must agree. TYPE is bool, int8 to
/// int64, uint8 to uint64, float32 or float64. x varies fastest, and time slowest.
Result<Volume> readRawHeader(const std::filesystem::path& path, std::string_view line);

}  // namespace t4d::voxel4d
