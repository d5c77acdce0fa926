#pragma once

#include "voxel4d/volumes/sample_reader.h"

namespace t4d::voxel4d {

/// Opens the samples of a volume that are read, of those in one of its files: whole, or those of a
/// region one after another.
Result<std::unique_ptr<SampleReader>> openRegion(const Volume& volume, const SampleData& data);

}  // namespace t4d::voxel4d
