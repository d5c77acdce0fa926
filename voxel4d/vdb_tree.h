#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <openvdb/openvdb.h>

#include "t4d/frames.h"
#include "voxel4d/frame_file.h"
#include "voxel4d/vdb_stream.h"

namespace t4d::voxel4d {

/// The coding of the values of a tree.
struct VdbCoding {
  std::uint32_t compression = 0;  ///< openvdb::io::COMPRESS_*
  bool half = false;              ///< values of voxels and tiles have 16 bits
};

/// The part of a tree that is read, and where its values go.
struct VdbTreeOptions {
  /// The values of leaf nodes are put into a file if they have this many bytes or more.
  std::size_t largeTree = kLargeFrame;
  /// Values outside are the background, inactive, and are not kept in memory.
  std::optional<openvdb::CoordBBox> region = {};
};

/// A tree, and the values of its leaf nodes if it has none.
struct VdbTree {
  openvdb::TreeBase::Ptr tree;
  std::unique_ptr<FrameFile> values;
  std::uint64_t activeVoxels = 0;  ///< of the whole tree
};

/// Whether readVdbTree supports a tree type: float, double, int32, bool, mask and vec3s trees of
/// OpenVDB's default configuration.
bool canReadVdbTree(const std::string& treeType);

/// Reads a tree of OpenVDB's file format version 222 to 224.
///
/// OpenVDB's own readers trust the file: the size of compressed values, so that they may write past
/// the end of a buffer; numbers that represent a bool; the order of nodes. After a node that ends
/// early they leave pointers uninitialized. So every node is created here, after everything in it
/// has been checked. OpenVDB only decompresses data of the right size.
///
/// If the values of leaf nodes take VdbTreeOptions::largeTree bytes or more, they are put into a
/// file instead of the tree: those of a node at the number that is its transient data.
///
/// Throws VdbDamage and the exceptions of the stream and of OpenVDB.
VdbTree readVdbTree(VdbStream& stream, const std::string& treeType, const VdbCoding& coding,
                    const VdbTreeOptions& options);

}  // namespace t4d::voxel4d
