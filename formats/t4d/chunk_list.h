#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "formats/t4d/chunk_file.h"

namespace t4d::formats {

/// The chunks of a .t4d file in memory, HEAD first. Follows the lengths alone, verifies nothing,
/// and stops at the footer or where no whole chunk fits.
std::vector<ChunkHeader> listChunks(std::string_view file);

/// Corrects every checksum of a .t4d file in memory that its lengths lead to, and nothing else.
void repairChecksums(std::string& file);

}  // namespace t4d::formats
