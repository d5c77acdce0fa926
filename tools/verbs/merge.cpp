#include "tools/verbs/merge.h"

#include "tools/verbs/members.h"

namespace t4d::verbs {

std::uint64_t MergeReport::vertices() const {
  std::uint64_t sum = 0;
  for (const Body& body : bodies) sum += body.summary.vertices;
  return sum;
}

std::uint64_t MergeReport::tetrahedra() const {
  std::uint64_t sum = 0;
  for (const Body& body : bodies) sum += body.summary.tetrahedra;
  return sum;
}

Result<MergeReport> merge(const std::vector<std::string>& files, const std::string& output,
                          Observer& observer) {
  const auto stage = observer.stage("merging");
  auto merged = formats::mergeT4d({files.begin(), files.end()}, output, stage->callback());
  if (!merged) return merged.error();
  return MergeReport{std::move(*merged), files};
}

void describe(Members& members, const MergeReport& report) {
  members("files", report.files.size(), "Files that were merged.").atLeast(1);
  members("bodies", report.bodies, "Bodies of the file, in its order.",
          [&](Members& own, const MergeReport::Body& body) {
            own("name", body.name,
                "Name of the body; with a number behind it where another one had it first.");
            own("file", report.files.empty() ? std::string() : report.files[body.file],
                "The file that it is from.");
            own("slabs", body.summary.slabs, "Slabs of the body.");
            own("vertices", body.summary.vertices, "Vertices of the body.");
            own("tetrahedra", body.summary.tetrahedra, "Cells of the body.");
          })
      .itemsFrom(1);
  members("vertices", report.vertices(), "Vertices of all bodies.");
  members("tetrahedra", report.tetrahedra(), "Cells of all bodies.");
  members("bytes", report.bytes, "Size of the file.");
}

}  // namespace t4d::verbs
