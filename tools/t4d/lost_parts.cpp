#include "tools/t4d/lost_parts.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "model/amount_text.h"

namespace t4d::tools {

void addLostParts(Members& members, const voxel4d::LostParts& parts) {
  members("parts_lost", parts.listed,
          "Parts that move by more than their width between two frames, so that nothing is left of "
          "them in between; the first thousand.",
          [](Members& own, const voxel4d::LostPart& part) {
            own("frame", part.frame, "The last frame that has it, counted from 0.");
            own("time", part.time, "Of that frame.");
            own("point", part.point, "Its centroid there: x, y and z.");
            own("voxels", part.voxels, "Lattice points inside of it there.").atLeast(1);
          })
      .joined(Joined::Appended);
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

}  // namespace t4d::tools
