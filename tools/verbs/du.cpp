#include "tools/verbs/du.h"

#include <algorithm>
#include <functional>

#include "tools/verbs/info.h"
#include "tools/verbs/members.h"

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

void describe(Members& members, const DuReport& report) {
  const auto perTetrahedron = [&](Members& own, std::uint64_t bytes) {
    own("bytes_per_tetrahedron", report.perTetrahedron(bytes),
        "Bytes divided by the tetrahedra of the file; 0 if it has none.")
        .atLeast(0);
  };
  members("bytes", report.bytes, "Size of the file, in bytes.");
  members("tetrahedra", report.tetrahedra, "Tetrahedra of all bodies.");
  perTetrahedron(members, report.bytes);
  members("chunks", report.chunks, "The chunks of each type, the largest total first.",
          [&](Members& own, const formats::T4dChunks& some) {
            own("type", some.type, "Type of the chunks.");
            own("count", some.count, "Number of chunks of this type.").atLeast(1);
            own("bytes", some.bytes, "Their bytes, including headers and padding.");
            perTetrahedron(own, some.bytes);
          });
  members("other_bytes", report.otherBytes, "Bytes of the header and the footer of the file.");
}

}  // namespace t4d::verbs
