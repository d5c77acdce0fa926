#include "tools/t4d/ctc_option.h"

#include <cmath>

#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

constexpr double kMostPointsAlongAxis = 1 << 20;  // along an axis

/// One number for all axes, or one for each.
double along(const std::vector<double>& numbers, std::size_t axis) {
  return numbers[numbers.size() == 1 ? 0 : axis];
}

}  // namespace

CLI::Option* CtcOption::addTo(CLI::App& command) {
  CLI::Option* ctc =
      command
          .add_option("--ctc", folder,
                      "Write label images and res_track.txt of the Cell Tracking Challenge into "
                      "this folder")
          ->check(someName())
          ->type_name("FOLDER");
  addNumbers(command, "--spacing", spacing, "--ctc: voxel edge lengths (default: 1)", 1, 3,
             "DX [DY DZ]")
      ->needs(ctc)
      ->check(numberAboveZero());
  addNumbers(command, "--origin", origin,
             "--ctc: position of the first voxel's centre (default: that of the mesh's bounds)", 3,
             3, "X Y Z")
      ->needs(ctc);
  addNumbers(command, "--size", size, "--ctc: voxels along x, y and z (default: all of the mesh)",
             3, 3, "NX NY NZ")
      ->needs(ctc)
      ->check(wholeNumber(1, static_cast<std::uint64_t>(kMostPointsAlongAxis)));
  return ctc;
}

std::string CtcOption::misuse() const {
  return spacing.size() == 2 ? "--spacing is one length, or three" : "";
}

Result<CtcReport> CtcOption::write(const Input& input, const TrackReport& report,
                                   const std::vector<double>& times, Observer& observer) const {
  LabelLattice lattice;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<int>(axis);
    if (!spacing.empty()) lattice.spacing[i] = along(spacing, axis);
    if (!origin.empty()) {
      if (!lattice.origin) lattice.origin = model::Point3::Zero();
      (*lattice.origin)[i] = origin[axis];
    }
    if (!size.empty()) {
      if (!lattice.size) lattice.size.emplace();
      (*lattice.size)[axis] = static_cast<std::uint32_t>(std::lround(size[axis]));
    }
  }
  return writeCtc(input, report, times, lattice, folder, observer);
}

}  // namespace t4d::tools
