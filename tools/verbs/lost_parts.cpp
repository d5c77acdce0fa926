#include "tools/verbs/lost_parts.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "model/amount_text.h"

namespace t4d::verbs {

nlohmann::ordered_json jsonOf(const voxel4d::LostParts& parts) {
  auto all = nlohmann::ordered_json::array();
  for (const voxel4d::LostPart& part : parts.listed) {
    all.push_back({{"frame", part.frame},
                   {"time", part.time},
                   {"point", {part.point.x(), part.point.y(), part.point.z()}},
                   {"voxels", part.voxels}});
  }
  return all;
}

void noticeLostParts(const voxel4d::LostParts& parts, std::vector<std::string>& notices) {
  if (parts.count == 0) return;
  const voxel4d::LostPart& first = parts.listed.front();
  std::string notice = fmt::format(
      "frame {} (counted from 0, at time {:.6g}): a part of {} at ({:.6g}, {:.6g}, {:.6g}) moves "
      "by its own width or more before the next frame, so that it shrinks or vanishes in between",
      first.frame, first.time, model::counted(first.voxels, "voxel"), first.point.x(),
      first.point.y(), first.point.z());
  if (parts.count > 1) {
    notice += fmt::format("; {} in all are lost like this", model::counted(parts.count, "part"));
  }
  notices.push_back(notice + "; use frames closer in time");
}

}  // namespace t4d::verbs
