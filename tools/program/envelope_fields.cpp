#include "tools/program/envelope_fields.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "t4d/voxel4d/point_field.h"
#include "tools/program/option_checks.h"
#include "tools/program/progress_bar.h"

namespace t4d::tools {
namespace {

using measure::SpaceLattice;
using measure::VisitFields;

/// A field, its option and its values.
struct FieldKind {
  const char* name;
  const char* help;
  double (*valueAt)(const VisitFields& fields, std::size_t row);
  bool whole;
};
constexpr std::array<FieldKind, 4> kFields = {{
    {"visits", "number of visits of each point, as int32",
     [](const VisitFields& f, std::size_t row) { return double(f.visits[row]); }, true},
    {"dwell", "how long each point is covered",
     [](const VisitFields& f, std::size_t row) { return f.dwell[row]; }, false},
    {"first", "when each point is first covered",
     [](const VisitFields& f, std::size_t row) { return f.first[row]; }, false},
    {"last", "when each point is last covered",
     [](const VisitFields& f, std::size_t row) { return f.last[row]; }, false},
}};

SpaceLattice shareOf(const SpaceLattice& whole, const model::Part& part) {
  SpaceLattice share = whole;
  const std::vector<double>& planes = whole.at[0];
  const model::PartRange own = voxel4d::planesOf(part, planes.size());
  const auto at = [&](std::uint64_t i) { return planes.begin() + static_cast<std::ptrdiff_t>(i); };
  share.at[0].assign(at(own.begin), at(own.end));
  return share;
}

voxel4d::PointField pointFieldOf(const FieldKind& kind, const FieldWork& work) {
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

void EnvelopeFields::addTo(CLI::App& command) {
  for (std::size_t i = 0; i < kFields.size(); ++i) {
    command
        .add_option(fmt::format("--{}", kFields[i].name), files[i],
                    fmt::format("Output file (.vdb): {}", kFields[i].help))
        ->type_name("FILE")
        ->check(vdbFile());
  }
}

bool EnvelopeFields::any() const {
  return std::ranges::any_of(files, [](const auto& file) { return !file.empty(); });
}

Result<void> checkFieldMemory(const SpaceLattice& lattice, const model::Part& part,
                              double maxMemoryGiB) {
  const double gib = measure::VisitFieldBuilder::bytesOf(shareOf(lattice, part)) / 0x1p30;
  if (gib <= maxMemoryGiB) return {};
  return fail(ErrorCode::Unsupported,
              fmt::format("fields with a voxel size of {} would need {:.1f} GiB of memory, more "
                          "than {:g} GiB; {:.2g} fits, and so may {}parts of them (--part)",
                          lattice.spacing, gib, maxMemoryGiB,
                          1.05 * lattice.spacing * std::cbrt(gib / maxMemoryGiB),
                          part.count > 1 ? "smaller " : ""),
              {}, Remedy::VoxelSize);
}

Result<std::vector<WrittenField>> writeFields(const EnvelopeFields& wanted, const FieldWork& work) {
  measure::VisitFieldBuilder builder(shareOf(work.lattice, work.part));
  if (auto put = work.put(builder); !put) return put.error();
  const VisitFields fields = builder.finish();
  const auto firstPlane =
      static_cast<std::uint32_t>(voxel4d::planesOf(work.part, work.lattice.at[0].size()).begin);
  const ProgressBar bar("writing fields");
  std::vector<WrittenField> written;
  for (std::size_t i = 0; i < kFields.size(); ++i) {
    if (wanted.files[i].empty()) continue;
    voxel4d::PointField field = pointFieldOf(kFields[i], work);
    field.value = [&](const std::array<std::uint32_t, 3>& at, double& value) {
      const std::size_t row = fields.rowOf({at[0] - firstPlane, at[1], at[2]});
      value = kFields[i].valueAt(fields, row);
      return fields.visits[row] > 0;
    };
    const auto bytes = voxel4d::writePointField(wanted.files[i], field);
    if (!bytes) return bytes.error();
    written.push_back({kFields[i].name, wanted.files[i], *bytes});
  }
  return written;
}

}  // namespace t4d::tools
