#pragma once

/// The library for programs that use it: the headers below, of the components that are installed.
/// What these include is installed with them.

#include "t4d/version.h"

// 4D meshes in memory, motions.
#include "t4d/model/flat_mesh.h"
#include "t4d/model/motion.h"
#include "t4d/model/sinks.h"
#include "t4d/model/slab.h"
#include "t4d/model/transformed.h"
#include "t4d/model/triangle_mesh.h"

// The mesh method.
#if __has_include("t4d/mesh4d/sweep.h")
#include "t4d/mesh4d/sweep.h"
#endif

// The voxel method.
#if __has_include("t4d/voxel4d/weave.h")
#include "t4d/voxel4d/array_frames.h"
#include "t4d/voxel4d/vdb_frames.h"
#include "t4d/voxel4d/volumes/volume_frames.h"
#include "t4d/voxel4d/voxelize.h"
#include "t4d/voxel4d/weave.h"
#endif

// Slices.
#if __has_include("t4d/slice/slice.h")
#include "t4d/slice/light_slice.h"
#include "t4d/slice/slice.h"
#include "t4d/slice/slice_at_times.h"
#endif

// Files: .t4d, triangle meshes, motions.
#if __has_include("t4d/formats/t4d/reader.h")
#include "t4d/formats/motion/motion_reader.h"
#include "t4d/formats/t4d/reader.h"
#include "t4d/formats/t4d/stream.h"
#include "t4d/formats/t4d/writer.h"
#include "t4d/formats/triangle/triangle_mesh_reader.h"
#include "t4d/formats/triangle/triangle_mesh_writer.h"
#endif

// Checks of a mesh in memory, or as it is made.
#if __has_include("t4d/measure/mesh_check.h")
#include "t4d/measure/mesh_check.h"
#endif

// The verbs of the program: files or meshes in memory, options, a report.
#if __has_include("t4d/verbs/sweep.h")
#include "t4d/verbs/collide.h"
#include "t4d/verbs/compare.h"
#include "t4d/verbs/compare_methods.h"
#include "t4d/verbs/compress.h"
#include "t4d/verbs/convert.h"
#include "t4d/verbs/diff.h"
#include "t4d/verbs/du.h"
#include "t4d/verbs/envelope.h"
#include "t4d/verbs/file_formats.h"
#include "t4d/verbs/filter.h"
#include "t4d/verbs/flipbook.h"
#include "t4d/verbs/frames.h"
#include "t4d/verbs/info.h"
#include "t4d/verbs/join.h"
#include "t4d/verbs/measure.h"
#include "t4d/verbs/mend.h"
#include "t4d/verbs/merge.h"
#include "t4d/verbs/mill.h"
#include "t4d/verbs/quality.h"
#include "t4d/verbs/rasterize.h"
#include "t4d/verbs/recover.h"
#include "t4d/verbs/resolve.h"
#include "t4d/verbs/simplify.h"
#include "t4d/verbs/slice.h"
#include "t4d/verbs/sweep.h"
#include "t4d/verbs/track.h"
#include "t4d/verbs/transform.h"
#include "t4d/verbs/validate.h"
#include "t4d/verbs/view.h"
#include "t4d/verbs/voxelize.h"
#include "t4d/verbs/weave.h"
#endif

// Tests of programs that make 4D meshes.
#if __has_include("t4d/conformance/backends/run.h")
#include "t4d/conformance/backends/run.h"
#endif
