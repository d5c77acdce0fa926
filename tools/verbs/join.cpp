#include "tools/verbs/join.h"

#include "convert/frame_files.h"
#include "tools/verbs/members.h"
#include "voxel4d/point_field_parts.h"

namespace t4d::verbs {
namespace {

std::uint64_t sumOf(const formats::JoinReport& report,
                    std::uint64_t formats::BodySummary::*number) {
  std::uint64_t sum = 0;
  for (const formats::BodySummary& body : report.bodies) sum += body.*number;
  return sum;
}

}  // namespace

std::uint64_t JoinReport::slabs() const { return sumOf(*this, &formats::BodySummary::slabs); }
std::uint64_t JoinReport::vertices() const { return sumOf(*this, &formats::BodySummary::vertices); }
std::uint64_t JoinReport::tetrahedra() const {
  return sumOf(*this, &formats::BodySummary::tetrahedra);
}

Result<JoinReport> join(const std::vector<std::string>& parts, const std::string& output,
                        JoinInto into, Observer& observer) {
  const std::vector<std::filesystem::path> files(parts.begin(), parts.end());
  const bool named = into == JoinInto::Manifest;
  const auto stage = observer.stage(named ? "checking" : "joining");
  auto joined = named ? formats::writeManifest(files, output, stage->callback())
                      : formats::joinT4d(files, output, stage->callback());
  if (!joined) return joined.error();
  return JoinReport{std::move(*joined)};
}

Result<FieldJoin> joinFields(const std::vector<std::string>& parts, const std::string& output) {
  const std::vector<std::filesystem::path> files(parts.begin(), parts.end());
  const auto joined = voxel4d::joinPointFields(files, output);
  if (!joined) return joined.error();
  return FieldJoin{files.size(), joined->name, joined->activePoints, joined->bytes};
}

Result<FramesJoin> joinFrames(const std::vector<std::string>& parts, const std::string& output) {
  const auto frames = convert::joinManifests({parts.begin(), parts.end()}, output);
  if (!frames) return frames.error();
  return FramesJoin{parts.size(), *frames};
}

namespace {

constexpr const char* kParts = "Files that were joined.";

}  // namespace

void describe(Members& members, const JoinReport& report) {
  members("parts", report.parts, kParts).atLeast(1);
  members("slabs", report.slabs(), "Slabs of the file.");
  members("vertices", report.vertices(),
          "Vertices, those where two slabs or two parts meet counted once.");
  members("tetrahedra", report.tetrahedra(), "Cells of all slabs.");
  members("bytes", report.bytes, "Size of the file.");
}

void describe(Members& members, const FieldJoin& report) {
  members("parts", report.parts, kParts).atLeast(1);
  members("field", report.field, "Of fields: which one.")
      .oneOf({"visits", "dwell", "first", "last"});
  members("active", report.active, "Of fields: points that are visited.");
  members("bytes", report.bytes, "Size of the file.");
}

void describe(Members& members, const FramesJoin& report) {
  members("parts", report.parts, kParts).atLeast(1);
  members("frames", report.frames, "Of manifests: the frames of the series.").atLeast(1);
}

}  // namespace t4d::verbs
