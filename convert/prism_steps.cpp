#include "convert/prism_steps.h"

#include <utility>

#include <fmt/format.h>

#include "slice/prisms.h"

namespace t4d::convert {

using model::Slab;

Error PrismSteps::no(double time, const std::string& why) {
  return fail(ErrorCode::Unsupported, fmt::format("at time {}, {}", time, why));
}

Result<void> PrismSteps::put(const Slab& slab) {
  if (auto checked = checkSlab(slab); !checked) return checked;
  if (!(slab.timeEnd > slab.timeBegin)) {
    if (connectivity_ && !slab.upperLayer().empty()) return no(slab.timeBegin, "it appears again");
    return {};
  }
  if (connectivity_ && slab.timeBegin != end_) return no(slab.timeBegin, "it appears again");
  if (auto same = checkTriangles(slab); !same) return same;
  end_ = slab.timeEnd;
  return step(slab);
}

Result<void> PrismSteps::checkTriangles(const Slab& slab) {
  if (slab.connectivity == connectivity_) return {};
  if (auto checked = checkConnectivity(*slab.connectivity); !checked) return checked;
  auto prisms = slice::prismsOf(*slab.connectivity);
  if (!prisms) {
    return no(slab.timeBegin, "its slab does not consist of prisms: " + prisms.error().message);
  }
  if (connectivity_ && prisms->triangles != triangles_) {
    return no(slab.timeBegin, "its triangles change");
  }
  triangles_ = std::move(prisms->triangles);
  connectivity_ = slab.connectivity;
  return {};
}

Error ofBody(const std::string& body, const std::string& isNot, Error error) {
  if (error.code == ErrorCode::Unsupported && error.where.empty()) {
    error.message = fmt::format("body '{}' {}: {}", body, isNot, error.message);
  }
  return error;
}

}  // namespace t4d::convert
