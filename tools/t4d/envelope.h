#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "t4d/envelope.h"
#include "t4d/mesh.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/time_window.h"

namespace t4d::tools {

class Members;

/// The .vdb files of what a motion does at the points of a lattice; "" for none.
struct VisitFieldFiles {
  std::string visits = {};  ///< how often a point is visited
  std::string dwell = {};   ///< how long it is covered
  std::string first = {};   ///< when it is covered first
  std::string last = {};    ///< and last

  bool any() const;
};

struct WrittenField {
  std::string name;
  std::string file;
  std::uint64_t bytes;
};

struct EnvelopeOptions {
  TimeWindow window = {};
  bool each = false;  ///< an envelope of each body, not one of all
  /// A file to write, in any of formats::writableTriangleMeshExtensions; with `each`, one for each
  /// body if `{body}` is in its name (body_files.h). "" for none.
  std::string output = {};
  bool center = false;  ///< write coordinates about the middle; the file says where it was
  /// The spacing of the lattice, in length units; without it, edit::defaultVoxelSize.
  std::optional<double> voxelSize = {};
  double memory = 4e9;  ///< the most bytes
  bool exact = false;   ///< as edit::EnvelopeOptions::exact
  /// Make an envelope that contains the whole motion (edit::EnvelopeOptions::reach); not exact. The
  /// following two imply it.
  bool outside = false;
  std::optional<double> inflate = {};  ///< with all that is within this distance of the motion
  std::optional<std::uint64_t> simplify = {};  ///< with at most this many triangles
  VisitFieldFiles fields = {};                 ///< fields of all bodies together, on the lattice
  /// Make only this part of the fields, and no envelope.
  std::optional<model::Part> part = {};
  std::string generator = {};  ///< program and version, for parts of fields

  bool contains() const { return outside || inflate || simplify; }
};

/// The places where a body, or several, have been.
struct Passage {
  std::string name;  ///< of the body; "envelope" of several
  measure::Silhouette silhouette = {};
  /// How far the mesh is from the motion, as measure::chordBound; nothing if that is not known of a
  /// body, and for a part of the fields, which does not need it.
  std::optional<double> chordBound = {};
  edit::Envelope envelope = {};  ///< empty until it is made
  std::string file = {};         ///< "" if none is written

  /// If the envelope contains the motion: the maximum distance of its points from the motion, or of
  /// its surface from it if simplified. Nothing if the motion is not known.
  std::optional<double> outsideBy() const;
  /// Whether an exact envelope takes seconds.
  bool hasFewTriangles() const;
};

struct Passages {
  Input input;  ///< only bodies that have a cell within the span
  model::TimeSpan span;
  std::vector<Passage> all;  ///< of each body, or one of all
};

/// Finds the silhouettes of the bodies within the time window.
Result<Passages> passagesOf(const Input& input, const EnvelopeOptions& options,
                            Observer& observer = nobody());

/// The most parts that the fields can be divided into. Fails if nothing has a volume.
Result<std::uint64_t> mostFieldParts(const Passages& passages, const EnvelopeOptions& options);

/// The error of a mesh whose hypervolume is not the same computed in two ways.
std::optional<std::string> doubtOfHypervolume(const Passage& passage, const model::TimeSpan& span);

struct EnvelopeReport {
  Passages passages;          ///< with their envelopes, except for a part
  EnvelopeOptions options;    ///< with which it was made
  double fieldVoxelSize = 0;  ///< 0 without fields
  std::vector<WrittenField> fields = {};
  double seconds = 0;                        ///< without those of passagesOf, if that was called
  std::vector<std::string> fileLosses = {};  ///< what the format of `output` cannot hold

  /// Parts that are missing from the envelopes, or may be, and from the files.
  std::vector<std::string> losses() const;
};

/// Makes the envelopes of passages (edit::envelopeOf, edit::collisionMeshOf), writes them, and
/// writes the fields. Fails for voxels of a wrong size with
/// Remedy::VoxelSize, VoxelSizeOrOutside, VoxelSizeOrExact or VoxelSizeOrParts; and with
/// NotExact or Center where these help.
Result<EnvelopeReport> envelope(Passages passages, const EnvelopeOptions& options,
                                Observer& observer = nobody());

/// The solid that a motion passes through, from the mesh: with passagesOf, and a note on each
/// doubtful hypervolume.
Result<EnvelopeReport> envelope(const Input& input, const EnvelopeOptions& options = {},
                                Observer& observer = nobody());

void describe(Members& members, const EnvelopeReport& report);

}  // namespace t4d::tools
