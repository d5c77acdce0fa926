#include "tools/verbs/du.h"

#include <algorithm>
#include <functional>

#include <nlohmann/json.hpp>

#include "tools/verbs/info.h"
#include "tools/verbs/json_text.h"

namespace t4d::verbs {

double DuReport::perTetrahedron(std::uint64_t ofBytes) const {
  return tetrahedra == 0 ? 0 : static_cast<double>(ofBytes) / static_cast<double>(tetrahedra);
}

Result<DuReport> du(const std::string& path) {
  auto file = info(path);
  if (!file) return file.error();
  DuReport report{.name = file->name,
                  .bytes = file->bytes,
                  .tetrahedra = file->total().tetrahedra,
                  .chunks = std::move(file->chunks),
                  .otherBytes = file->bytes};
  std::ranges::stable_sort(report.chunks, std::ranges::greater(), &formats::T4dChunks::bytes);
  for (const formats::T4dChunks& some : report.chunks) report.otherBytes -= some.bytes;
  return report;
}

std::string jsonOf(const DuReport& report) {
  nlohmann::ordered_json value = {{"bytes", report.bytes},
                                  {"tetrahedra", report.tetrahedra},
                                  {"bytes_per_tetrahedron", report.perTetrahedron(report.bytes)},
                                  {"chunks", nlohmann::ordered_json::array()},
                                  {"other_bytes", report.otherBytes}};
  for (const formats::T4dChunks& some : report.chunks) {
    value["chunks"].push_back({{"type", some.type},
                               {"count", some.count},
                               {"bytes", some.bytes},
                               {"bytes_per_tetrahedron", report.perTetrahedron(some.bytes)}});
  }
  return jsonText(value);
}

}  // namespace t4d::verbs
