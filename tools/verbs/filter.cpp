#include "tools/verbs/filter.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "edit/clip_time.h"
#include "platform/stopwatch.h"
#include "t4d/file.h"
#include "tools/verbs/json_text.h"

namespace t4d::verbs {
namespace {

Result<void> filterBodies(const Input& input, formats::T4dWriter& writer, FilterReport& report,
                          Observer& observer) {
  const auto stage = observer.stage("filtering", slabCountOf(input.bodies), "slabs");
  for (std::size_t i = 0; i < input.bodies.size(); ++i) {
    const auto& [name, source] = input.bodies[i];
    const auto clip =
        edit::clipTime(*source, report.span, writer.body(i), stage->part(source->slabCount()));
    if (!clip) {
      Error error = clip.error();
      if (error.where.empty()) error.where = placeIn(input.name, fmt::format("body '{}'", name));
      return error;
    }
    if (clip->cells == 0) {
      return invalid(fmt::format("body '{}' is empty between the times {} and {}; choose others, "
                                 "or other bodies",
                                 name, report.span.begin, report.span.end),
                     input.name, Remedy::OtherBodies);
    }
    report.slabs += clip->slabs;
    report.slabsCut += clip->cutSlabs;
    report.cells += clip->cells;
    for (const edit::RunEnd& end : clip->caps) {
      report.caps.push_back({name, end.time, end.triangles});
    }
  }
  report.cells += report.capCells();
  return {};
}

}  // namespace

std::uint64_t FilterReport::capCells() const {
  std::uint64_t sum = 0;
  for (const FilterCap& cap : caps) sum += cap.triangles;
  return sum;
}

Result<FilterReport> filter(const Input& input, const FilterOptions& options, Observer& observer) {
  const platform::Stopwatch stopwatch;
  const auto span = options.window.spanIn(input);
  if (!span) return span.error();
  FilterReport report;
  report.span = *span;
  Input kept = input;
  keepThoseWithin(*span, kept, report.notices);
  report.bodies = kept.bodies.size();
  auto writer = formats::T4dWriter::create(options.output, metadataOf(kept, options.generator),
                                           {.compression = options.compression});
  if (!writer) return writer.error();
  if (auto done = filterBodies(kept, *writer, report, observer); !done) return done.error();
  const auto bytes = finishEdited(*writer, kept);
  if (!bytes) return bytes.error();
  report.bytes = *bytes;
  report.losses = writer->losses();
  report.seconds = stopwatch.seconds();
  return report;
}

std::string jsonOf(const FilterReport& report, std::uint64_t peakBytes) {
  auto caps = nlohmann::ordered_json::array();
  for (const FilterCap& cap : report.caps) {
    caps.push_back({{"body", cap.body}, {"time", cap.time}, {"triangles", cap.triangles}});
  }
  return jsonText({{"bodies", report.bodies},
                   {"time_begin", report.span.begin},
                   {"time_end", report.span.end},
                   {"slabs", report.slabs},
                   {"slabs_cut", report.slabsCut},
                   {"tetrahedra", report.cells},
                   {"caps", caps},
                   {"bytes", report.bytes},
                   {"seconds", report.seconds},
                   {"peak_bytes", peakBytes}});
}

}  // namespace t4d::verbs
