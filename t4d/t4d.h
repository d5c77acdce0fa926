#pragma once

/// All of the library that programs use, of the components that are installed. What else is in
/// these folders are parts of what is here.

// 4D meshes in memory, motions.
#include "t4d/model/body.h"
#include "t4d/model/flat_mesh.h"
#include "t4d/model/motion.h"
#include "t4d/model/sinks.h"
#include "t4d/model/slab.h"
#include "t4d/model/transformed.h"
#include "t4d/model/triangle_mesh.h"
#include "t4d/model/units.h"

// The mesh method.
#if __has_include("t4d/mesh4d/sweep.h")
#include "t4d/mesh4d/sweep.h"
#endif

// The voxel method.
#if __has_include("t4d/voxel4d/array_frames.h")
#include "t4d/voxel4d/array_frames.h"
#include "t4d/voxel4d/frame_spacing.h"
#include "t4d/voxel4d/sampled_frames.h"
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
#include "t4d/slice/velocity.h"
#endif

// Animations and files for each frame.
#if __has_include("t4d/convert/flipbook.h")
#include "t4d/convert/flipbook.h"
#include "t4d/convert/frame_files.h"
#include "t4d/convert/morph_flipbook.h"
#include "t4d/convert/rigid_flipbook.h"
#endif

// Files.
#if __has_include("t4d/formats/toolpath/cutter_location_reader.h")
#include "t4d/formats/animation/deformation_reader.h"
#include "t4d/formats/gltf/gltf_animation.h"
#include "t4d/formats/mesh4d/mesh4d_formats.h"
#include "t4d/formats/motion/motion_reader.h"
#include "t4d/formats/t4d/join.h"
#include "t4d/formats/t4d/reader.h"
#include "t4d/formats/t4d/stream.h"
#include "t4d/formats/t4d/writer.h"
#include "t4d/formats/toolpath/cutter_location_reader.h"
#include "t4d/formats/toolpath/gcode_reader.h"
#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/formats/usd/usd_animation.h"
#endif

// Checks and questions.
#if __has_include("t4d/measure/collision_verdict.h")
#include "t4d/measure/clearance_over_time.h"
#include "t4d/measure/collision_verdict.h"
#include "t4d/measure/compare.h"
#include "t4d/measure/mesh_quality.h"
#endif

// Repairs and changes.
#if __has_include("t4d/edit/clip_time.h")
#include "t4d/edit/clip_time.h"
#include "t4d/edit/cut_into_slabs.h"
#include "t4d/edit/envelope.h"
#include "t4d/edit/map_space_time.h"
#include "t4d/edit/mend_deformation.h"
#include "t4d/edit/mend_mesh4d.h"
#include "t4d/edit/mend_surface.h"
#include "t4d/edit/resolve.h"
#include "t4d/edit/simplify.h"
#endif

// What the verbs of the program do to files.
#if __has_include("t4d/verbs/diff.h")
#include "t4d/verbs/collide.h"
#include "t4d/verbs/compare.h"
#include "t4d/verbs/compare_methods.h"
#include "t4d/verbs/compress.h"
#include "t4d/verbs/diff.h"
#include "t4d/verbs/envelope.h"
#include "t4d/verbs/filter.h"
#include "t4d/verbs/join.h"
#include "t4d/verbs/measure.h"
#include "t4d/verbs/merge.h"
#include "t4d/verbs/mill.h"
#include "t4d/verbs/quality.h"
#include "t4d/verbs/rasterize.h"
#include "t4d/verbs/recover.h"
#include "t4d/verbs/resolve.h"
#include "t4d/verbs/simplify.h"
#include "t4d/verbs/sweep.h"
#include "t4d/verbs/transform.h"
#include "t4d/verbs/validate.h"
#include "t4d/verbs/voxelize.h"
#include "t4d/verbs/weave.h"
#endif

// Machining.
#if __has_include("t4d/mill/mill.h")
#include "t4d/mill/mill.h"
#endif
