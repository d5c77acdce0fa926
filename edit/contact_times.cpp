#include "edit/contact_times.h"

#include <algorithm>

#include "model/progress.h"
#include "t4d/collide.h"

namespace t4d::edit {

Result<std::vector<ContactTime>> contactTimes(std::span<const model::Body> obstacles,
                                              const model::Body& body, double clearance,
                                              const model::Progress& progress) {
  std::vector<ContactTime> found;
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const auto collision = measure::collide(
        *obstacles[i].source, *body.source,
        {.clearance = clearance > 0, .clearanceOverTime = clearance > 0, .overlapVolumes = false},
        model::eachOf(progress, i, obstacles.size()));
    if (!collision) return collision.error();
    for (const measure::ContactInterval& contact : collision->intervals) {
      found.push_back({{contact.begin, contact.end},
                       (contact.begin + contact.end) / 2,
                       contact.first.point,
                       obstacles[i].name});
    }
    if (!collision->clearance || collision->clearance->lowerBound >= clearance) continue;
    const measure::Clearance& nearest = *collision->clearance;
    const std::size_t before = found.size();
    for (const measure::ClearanceOver& over : collision->clearanceOverTime) {
      if (over.distance > clearance || over.distance == 0) continue;
      const bool isNearest = over.span.begin <= nearest.time && nearest.time <= over.span.end;
      found.push_back({over.span, isNearest ? nearest.time : (over.span.begin + over.span.end) / 2,
                       nearest.pointB, obstacles[i].name});
    }
    if (found.size() == before) {
      found.push_back(
          {{nearest.time, nearest.time}, nearest.time, nearest.pointB, obstacles[i].name});
    }
  }
  std::ranges::stable_sort(found, {}, [](const ContactTime& one) { return one.span.begin; });
  return found;
}

}  // namespace t4d::edit
