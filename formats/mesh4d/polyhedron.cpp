#include "formats/mesh4d/polyhedron.h"

#include <algorithm>

namespace t4d::formats {

void pullPolyhedron(std::span<const std::span<const std::uint32_t>> faces,
                    const std::function<void(const model::Cell&)>& take) {
  std::uint32_t apex = ~std::uint32_t{0};
  for (const auto& face : faces) apex = std::min(apex, *std::ranges::min_element(face));
  for (const auto& face : faces) {
    if (std::ranges::find(face, apex) != face.end()) continue;
    const std::size_t n = face.size();
    const auto first = static_cast<std::size_t>(std::ranges::min_element(face) - face.begin());
    for (std::size_t i = 1; i + 1 < n; ++i) {
      take({apex, face[first], face[(first + i) % n], face[(first + i + 1) % n]});
    }
  }
}

}  // namespace t4d::formats
