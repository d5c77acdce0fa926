#include "tools/t4d/flat_caps.h"

#include <fmt/format.h>

#include "model/amount_text.h"

namespace t4d::tools {

void noticeFlatCaps(voxel4d::CapStyle caps, const voxel4d::WeaveReport& report,
                    std::vector<std::string>& notices) {
  const std::uint64_t inCaps = report.capTetrahedra[0] + report.capTetrahedra[1];
  if (caps != voxel4d::CapStyle::Flat || inCaps <= report.tetrahedra / 2) return;
  notices.push_back(
      fmt::format("{} of {} tetrahedra are in the flat caps; graded caps close the "
                  "same solid with fewer",
                  model::grouped(inCaps), model::grouped(report.tetrahedra)));
}

}  // namespace t4d::tools
