#pragma once

/// The library for programs that use it: the headers below, of the components that are installed.
/// What these include is installed with them.

#include "t4d/version.h"

// 4D meshes in memory, motions.
#include "model/flat_mesh.h"
#include "model/motion.h"
#include "model/sinks.h"
#include "model/slab.h"
#include "model/transformed.h"
#include "model/triangle_mesh.h"

// The mesh method.
#if __has_include("mesh4d/sweep.h")
#include "mesh4d/sweep.h"
#endif

// The voxel method.
#if __has_include("voxel4d/weave.h")
#include "voxel4d/array_frames.h"
#include "voxel4d/vdb_frames.h"
#include "voxel4d/volumes/volume_frames.h"
#include "voxel4d/voxelize.h"
#include "voxel4d/weave.h"
#endif

// Slices.
#if __has_include("slice/slice.h")
#include "slice/light_slice.h"
#include "slice/slice.h"
#include "slice/slice_at_times.h"
#endif

// Files: .t4d, triangle meshes, motions.
#if __has_include("formats/t4d/reader.h")
#include "formats/motion/motion_reader.h"
#include "formats/t4d/reader.h"
#include "formats/t4d/stream.h"
#include "formats/t4d/writer.h"
#include "formats/triangle/triangle_mesh_reader.h"
#include "formats/triangle/triangle_mesh_writer.h"
#endif

// Checks of a mesh in memory, or as it is made.
#if __has_include("measure/mesh_check.h")
#include "measure/mesh_check.h"
#endif

// The verbs of the program: files or meshes in memory, options, a report.
#if __has_include("tools/verbs/sweep.h")
#include "tools/verbs/collide.h"
#include "tools/verbs/compare.h"
#include "tools/verbs/compare_methods.h"
#include "tools/verbs/compress.h"
#include "tools/verbs/convert.h"
#include "tools/verbs/diff.h"
#include "tools/verbs/du.h"
#include "tools/verbs/envelope.h"
#include "tools/verbs/file_formats.h"
#include "tools/verbs/filter.h"
#include "tools/verbs/flipbook.h"
#include "tools/verbs/frames.h"
#include "tools/verbs/info.h"
#include "tools/verbs/join.h"
#include "tools/verbs/measure.h"
#include "tools/verbs/mend.h"
#include "tools/verbs/merge.h"
#include "tools/verbs/mill.h"
#include "tools/verbs/quality.h"
#include "tools/verbs/rasterize.h"
#include "tools/verbs/recover.h"
#include "tools/verbs/resolve.h"
#include "tools/verbs/simplify.h"
#include "tools/verbs/slice.h"
#include "tools/verbs/sweep.h"
#include "tools/verbs/track.h"
#include "tools/verbs/transform.h"
#include "tools/verbs/validate.h"
#include "tools/verbs/view.h"
#include "tools/verbs/voxelize.h"
#include "tools/verbs/weave.h"
#endif

// Tests of programs that make 4D meshes.
#if __has_include("conformance/backends/run.h")
#include "conformance/backends/run.h"
#endif
