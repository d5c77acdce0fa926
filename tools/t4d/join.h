#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/t4d/join.h"
#include "tools/t4d/observer.h"

/// Joining what processes have made of the parts of a run; for their reports, see join_reports.h.
namespace t4d::tools {

class Members;

enum class JoinInto : std::uint8_t {
  File,      ///< copy the parts (formats::joinT4d)
  Manifest,  ///< name them in a .t4dm (formats::writeManifest)
};

struct JoinReport : formats::JoinReport {
  std::uint64_t slabs() const;  ///< of all bodies, as the following
  std::uint64_t vertices() const;
  std::uint64_t tetrahedra() const;
};

/// Joins .t4d files whose times follow one another.
Result<JoinReport> join(const std::vector<std::string>& parts, const std::string& output,
                        JoinInto into = JoinInto::File, Observer& observer = nobody());

struct FieldJoin {
  std::uint64_t parts = 0;
  std::string field;         ///< its name, such as "dwell"
  std::uint64_t active = 0;  ///< points that have a value
  std::uint64_t bytes = 0;
};

/// Joins the parts of a field of an envelope, .vdb files in any order (voxel4d::joinPointFields).
Result<FieldJoin> joinFields(const std::vector<std::string>& parts, const std::string& output);

struct FramesJoin {
  std::uint64_t parts = 0;
  std::uint64_t frames = 0;  ///< of the whole series
};

/// Joins the manifests of the parts of a series of frames (convert::joinManifests).
Result<FramesJoin> joinFrames(const std::vector<std::string>& parts, const std::string& output);

void describe(Members& members, const JoinReport& report);
void describe(Members& members, const FieldJoin& report);
void describe(Members& members, const FramesJoin& report);

}  // namespace t4d::tools
