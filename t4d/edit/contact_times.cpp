#include "t4d/edit/contact_times.h"

#include "t4d/convert/slice.h"
#include "t4d/edit/solid_sample.h"

namespace t4d::edit {

Result<std::vector<ContactTime>> contactTimes(std::span<const model::Body> obstacles,
                                              const model::Body& body, double clearance,
                                              const model::Progress& progress) {
  std::vector<ContactTime> found;
  const convert::TimeSlicer slicer(*body.source);
  for (const model::Body& obstacle : obstacles) {
    const convert::TimeSlicer other(*obstacle.source);
    const model::TimeSpan span = timeSpanOf(*obstacle.source);
    bool before = false;
    for (std::size_t i = 0; i < body.source->slabCount(); ++i) {
      const model::TimeSpan slab = body.source->timeSpan(i);
      if (progress) progress(static_cast<double>(i) / static_cast<double>(body.source->slabCount()));
      if (!(slab.begin < slab.end)) continue;
      for (int k = 0; k < 4; ++k) {
        const double time = slab.begin + (slab.end - slab.begin) * k / 4;
        if (time < span.begin || time > span.end) continue;
        const auto a = other.at(time);
        if (!a) return pass(a.error());
        const auto b = slicer.at(time);
        if (!b) return pass(b.error());
        if (a->mesh.triangles.empty() || b->mesh.triangles.empty()) continue;
        const SolidSample solidA(a->mesh);
        const SolidSample solidB(b->mesh);
        const model::Point3* place = nullptr;
        for (const model::Point3& point : b->mesh.vertices) {
          if (isNear(solidA.bounds(), point, clearance) && solidA.at(point).distance <= clearance) {
            place = &point;
          }
        }
        for (const model::Point3& point : a->mesh.vertices) {
          if (isNear(solidB.bounds(), point, clearance) && solidB.at(point).distance <= clearance) {
            place = &point;
          }
        }
        if (place != nullptr) {
          if (!before) found.push_back({{time, time}, time, *place, obstacle.name});
          found.back().span.end = time;
        }
        before = place != nullptr;
      }
    }
  }
  return found;
}

}  // namespace t4d::edit
