#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "model/parallel.h"
#include "model/voxel_size.h"
#include "t4d/frames.h"
#include "voxel4d/sample_box.h"

namespace t4d::voxel4d {
namespace {

class FieldFrames : public FrameSource {
 public:
  FieldFrames(std::vector<double> times, const std::array<std::size_t, 3>& size,
              const Lattice& lattice, FieldFunction field)
      : times_(std::move(times)), size_(size), lattice_(lattice), field_(std::move(field)) {}

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return times_.size(); }

  Result<Frame> frame(std::size_t index) override {
    const auto [nx, ny, nz] = size_;
    const auto values = std::make_shared<std::vector<double>>(nx * ny * nz);
    model::forEach(nx, [&, ny = ny, nz = nz](std::size_t x) {
      double* value = values->data() + x * ny * nz;
      for (std::size_t y = 0; y < ny; ++y) {
        for (std::size_t z = 0; z < nz; ++z) {
          const Eigen::Vector3d point(static_cast<double>(x), static_cast<double>(y),
                                      static_cast<double>(z));
          *value++ = field_(lattice_(point), times_[index]);
        }
      }
    });
    const auto stride = [](std::size_t count) {
      return static_cast<std::ptrdiff_t>(count * sizeof(double));
    };
    const SampleBox box = {SampleType::Float64,
                           reinterpret_cast<const std::byte*>(values->data()),
                           size_,
                           {stride(ny * nz), stride(nz), stride(1)}};
    const auto rule = arrayRule(box.type, "", {});
    if (!rule) return rule.error();
    const auto signs = usableSignsOf(box, *rule);
    if (!signs) return invalid(signs.error().message, placeOf(index));
    const auto outside = fieldOutside(*rule, signs->farthest);
    if (!outside) return outside.error();
    return frameOf(box, *rule, *signs, *outside, times_[index], values);
  }

 private:
  std::vector<double> times_;
  std::array<std::size_t, 3> size_;
  Lattice lattice_;
  FieldFunction field_;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> fieldFrames(std::vector<double> times,
                                                 const std::array<std::size_t, 3>& size,
                                                 const Lattice& lattice, FieldFunction field) {
  if (auto checked = checkArraySize(size); !checked) return checked.error();
  if (auto sized = model::checkVoxelSize(lattice.voxelSize); !sized) return sized.error();
  if (!lattice.origin.allFinite()) {
    return invalid(fmt::format("the origin is ({}, {}, {}); it must be finite", lattice.origin[0],
                               lattice.origin[1], lattice.origin[2]));
  }
  if (times.size() < 2) {
    return invalid(fmt::format("there are {} times; at least two are needed", times.size()));
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1]))) {
      return invalid(fmt::format(
          "time {} (counted from 0) is {}; times must be finite and increase", i, times[i]));
    }
  }
  return std::make_unique<FieldFrames>(std::move(times), size, lattice, std::move(field));
}

}  // namespace t4d::voxel4d
