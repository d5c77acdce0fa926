#include "tools/t4d/visit_field_files.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "model/voxel_size.h"
#include "voxel4d/point_field.h"
#include "voxel4d/vdb_voxel.h"

namespace t4d::tools {
namespace {

using measure::SpaceLattice;
using measure::VisitFields;

/// A field, its file and its values.
struct VisitFieldKind {
  const char* name;
  std::string VisitFieldFiles::*file;
  double (*valueAt)(const VisitFields& fields, std::size_t row);
  bool whole;
};
constexpr std::array<VisitFieldKind, 4> kVisitFields = {{
    {"visits", &VisitFieldFiles::visits,
     [](const VisitFields& f, std::size_t row) { return double(f.visits[row]); }, true},
    {"dwell", &VisitFieldFiles::dwell,
     [](const VisitFields& f, std::size_t row) { return f.dwell[row]; }, false},
    {"first", &VisitFieldFiles::first,
     [](const VisitFields& f, std::size_t row) { return f.first[row]; }, false},
    {"last", &VisitFieldFiles::last,
     [](const VisitFields& f, std::size_t row) { return f.last[row]; }, false},
}};

SpaceLattice latticeOfPart(const SpaceLattice& whole, const model::Part& part) {
  SpaceLattice share = whole;
  const std::vector<double>& planes = whole.at[0];
  const model::PartRange own = voxel4d::planesOf(part, planes.size());
  const auto at = [&](std::uint64_t i) { return planes.begin() + static_cast<std::ptrdiff_t>(i); };
  share.at[0].assign(at(own.begin), at(own.end));
  return share;
}

voxel4d::PointField pointFieldOf(const VisitFieldKind& kind, const VisitFieldWork& work) {
  voxel4d::PointField field;
  field.name = kind.name;
  field.whole = kind.whole;
  field.lattice.voxelSize = work.lattice.spacing;
  for (int axis = 0; axis < 3; ++axis) {
    field.lattice.origin[axis] = work.lattice.at[axis].front();
    field.counts[axis] = static_cast<std::uint32_t>(work.lattice.at[axis].size());
  }
  if (!work.run.empty()) field.part = {work.part, work.run};
  return field;
}

}  // namespace

bool VisitFieldFiles::any() const {
  return std::ranges::any_of(
      kVisitFields, [&](const VisitFieldKind& kind) { return !(this->*kind.file).empty(); });
}

Result<void> checkFields(const SpaceLattice& lattice, const model::Part& part, double memory) {
  if (auto good = voxel4d::checkVdbVoxel(lattice.spacing); !good) return good;
  const double bytes = measure::VisitFieldBuilder::bytesOf(latticeOfPart(lattice, part));
  if (bytes <= memory) return {};
  return model::tooMuchMemory({lattice.spacing, bytes, memory}, "the fields need",
                              fmt::format("{:.2g} fits, and so may {}parts of them",
                                          1.05 * lattice.spacing * std::cbrt(bytes / memory),
                                          part.count > 1 ? "smaller " : ""),
                              Remedy::VoxelSizeOrParts);
}

Result<std::vector<WrittenField>> writeVisitFields(const VisitFieldFiles& files,
                                                   const VisitFieldWork& work, Observer& observer) {
  measure::VisitFieldBuilder builder(latticeOfPart(work.lattice, work.part));
  if (auto put = work.put(builder); !put) return put.error();
  const VisitFields fields = builder.finish();
  const auto firstPlane =
      static_cast<std::uint32_t>(voxel4d::planesOf(work.part, work.lattice.at[0].size()).begin);
  const auto stage = observer.stage("writing fields");
  std::vector<WrittenField> written;
  for (const VisitFieldKind& kind : kVisitFields) {
    const std::string& file = files.*kind.file;
    if (file.empty()) continue;
    voxel4d::PointField field = pointFieldOf(kind, work);
    field.value = [&](const std::array<std::uint32_t, 3>& at, double& value) {
      const std::size_t row = fields.rowOf({at[0] - firstPlane, at[1], at[2]});
      value = kind.valueAt(fields, row);
      return fields.visits[row] > 0;
    };
    const auto bytes = voxel4d::writePointField(file, field);
    if (!bytes) return bytes.error();
    written.push_back({kind.name, file, *bytes});
  }
  return written;
}

}  // namespace t4d::tools
