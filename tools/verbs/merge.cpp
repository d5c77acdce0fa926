#include "tools/verbs/merge.h"

#include <nlohmann/json.hpp>

#include "tools/verbs/json_text.h"

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

std::string jsonOf(const MergeReport& report) {
  auto bodies = nlohmann::ordered_json::array();
  for (const MergeReport::Body& body : report.bodies) {
    bodies.push_back({{"name", body.name},
                      {"file", report.files[body.file]},
                      {"slabs", body.summary.slabs},
                      {"vertices", body.summary.vertices},
                      {"tetrahedra", body.summary.tetrahedra}});
  }
  return jsonText({{"files", report.files.size()},
                   {"bodies", bodies},
                   {"vertices", report.vertices()},
                   {"tetrahedra", report.tetrahedra()},
                   {"bytes", report.bytes}});
}

}  // namespace t4d::verbs
