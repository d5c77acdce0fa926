#pragma once

#include <string>

#include <openvdb/openvdb.h>

#include "t4d/voxel4d/vdb_stream.h"

namespace t4d::voxel4d {

/// How the values of a tree are stored.
struct VdbCoding {
  std::uint32_t compression = 0;  ///< openvdb::io::COMPRESS_*
  bool half = false;              ///< values of voxels and tiles have 16 bits
};

/// Whether readVdbTree knows a type of tree: float, double, bool and mask trees of OpenVDB's usual
/// configuration.
bool canReadVdbTree(const std::string& treeType);

/// Reads a tree as OpenVDB's versions of the format 222 to 224 store it.
///
/// OpenVDB's own reading believes what it reads: sizes of compressed values, of which it writes as
/// many as are announced to where it has room for others; numbers that stand for a bool; the order
/// of nodes; in a node that ends early, pointers that were never set. So every node is made here,
/// when all that it says has been judged. OpenVDB only decompresses, what has a right size.
///
/// Throws VdbDamage, the stream's exceptions and OpenVDB's.
openvdb::TreeBase::Ptr readVdbTree(VdbStream& stream, const std::string& treeType,
                                   const VdbCoding& coding);

}  // namespace t4d::voxel4d
