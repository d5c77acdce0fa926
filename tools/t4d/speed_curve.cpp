#include "tools/t4d/speed_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "formats/input_file.h"
#include "tools/t4d/numbers.h"
#include "tools/t4d/text_table.h"

namespace t4d::tools {
namespace {

struct Row {
  std::uint64_t line = 0;
  double playback = 0;  // seconds
  double value = 0;     // the time of the mesh, or its speed
};

struct Curve {
  bool isSpeed = false;
  std::vector<Row> rows = {};
};

Result<Row> rowOf(const TableLine& line, const formats::InputFile& file) {
  const auto where = file.atLine(line.number);
  if (line.fields.size() != 2) {
    return invalid(fmt::format("has {} columns, expected 2", line.fields.size()), where);
  }
  for (const std::string_view field : line.fields) {
    if (!numberOf(field)) {
      return invalid(fmt::format("found '{}', expected a number", quotable(field)), where);
    }
  }
  return Row{line.number, *numberOf(line.fields[0]), *numberOf(line.fields[1])};
}

Result<bool> isSpeedCurve(const std::optional<TableLine>& header, const formats::InputFile& file) {
  const auto found = header ? header->fields : std::vector<std::string_view>();
  if (found.size() == 2 && found[0] == "playback") {
    if (found[1] == "time") return false;
    if (found[1] == "speed") return true;
  }
  return invalid(fmt::format("found '{}', expected the header playback,time or playback,speed",
                             quotable(fmt::format("{}", fmt::join(found, ",")))),
                 file.atLine(header ? header->number : 1));
}

Result<Curve> readCurve(const std::string& path) {
  const auto file = formats::readInputFile(path);
  if (!file) return file.error();
  TableLines lines(file->bytes);
  const auto isSpeed = isSpeedCurve(lines.next(), *file);
  if (!isSpeed) return isSpeed.error();
  Curve curve{*isSpeed};
  while (const auto line = lines.next()) {
    const auto row = rowOf(*line, *file);
    if (!row) return row.error();
    if (!curve.rows.empty() && !(row->playback > curve.rows.back().playback)) {
      return invalid(fmt::format("playback {} follows {}; expected seconds that increase",
                                 row->playback, curve.rows.back().playback),
                     file->atLine(line->number));
    }
    curve.rows.push_back(*row);
  }
  if (curve.rows.empty()) return invalid("has no rows after its header", path);
  return curve;
}

/// The nearest whole number if `x` differs from it by rounding alone, otherwise `x`.
double wholeIfNear(double x) {
  const double ulp =
      std::nextafter(std::abs(x), std::numeric_limits<double>::infinity()) - std::abs(x);
  return std::abs(x - std::round(x)) <= model::kSameTimeUlps * ulp ? std::round(x) : x;
}

/// A row, and the way to the next one, on which the part u has a time that is less by
/// bend * u * (1 - u) than on a straight line.
struct Knot {
  double frame = 0;  // counted from the first row; a fraction where the row is between two frames
  double time = 0;
  double bend = 0;
};

bool isWhole(double x) { return x == std::floor(x); }

/// The time of a frame between two knots. Without a bend, times that people type as decimals are
/// met exactly.
double timeBetween(const Knot& a, const Knot& b, std::uint64_t frame) {
  const double passed = static_cast<double>(frame) - a.frame;
  const double length = b.frame - a.frame;
  if (a.bend == 0 && isWhole(passed) && isWhole(length)) {
    return model::dividedTime({a.time, b.time}, static_cast<std::uint64_t>(passed),
                              static_cast<std::uint64_t>(length));
  }
  const long double along = static_cast<long double>(passed) / length;
  const long double straight = a.time * (1 - along) + b.time * along;
  return static_cast<double>(straight - a.bend * along * (1 - along));
}

/// The integral of speeds from `begin`, with ends of `span` that are missed by rounding met.
std::vector<Knot> knotsOf(const Curve& curve, const model::TimeSpan& span, double framesPerSecond) {
  std::vector<Knot> knots;
  long double time = span.begin;
  const std::vector<Row>& rows = curve.rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double frame = wholeIfNear((rows[i].playback - rows[0].playback) * framesPerSecond);
    if (!curve.isSpeed) {
      knots.push_back({frame, rows[i].value});
      continue;
    }
    const auto now = static_cast<double>(time);
    knots.push_back({frame, model::timeWithin(span, now).value_or(now)});
    if (i + 1 == rows.size()) break;
    const long double half =
        (static_cast<long double>(rows[i + 1].playback) - rows[i].playback) / 2;
    knots.back().bend = static_cast<double>((rows[i + 1].value - rows[i].value) * half);
    time += (static_cast<long double>(rows[i].value) + rows[i + 1].value) * half;
  }
  return knots;
}

}  // namespace

Result<std::vector<double>> timesOfCurve(const std::string& path, const model::TimeSpan& span,
                                         double framesPerSecond, std::uint64_t most) {
  const auto curve = readCurve(path);
  if (!curve) return curve.error();
  const std::vector<Knot> knots = knotsOf(*curve, span, framesPerSecond);
  const double last = std::floor(knots.back().frame);
  if (!(last < static_cast<double>(most))) {
    return invalid(fmt::format("lasts {} s, at {} frames a second more than {} frames",
                               curve->rows.back().playback - curve->rows.front().playback,
                               framesPerSecond, most),
                   path);
  }
  std::vector<double> times;
  std::size_t after = 0;
  for (std::uint64_t frame = 0; static_cast<double>(frame) <= last; ++frame) {
    while (knots[after].frame < static_cast<double>(frame)) ++after;
    const double time = knots[after].frame == static_cast<double>(frame)
                            ? knots[after].time
                            : timeBetween(knots[after - 1], knots[after], frame);
    if (!model::timeWithin(span, time)) {
      return invalid(
          fmt::format(
              "time {} at second {} of playback is outside the mesh, which lasts from {} to "
              "{}",
              time, curve->rows[0].playback + static_cast<double>(frame) / framesPerSecond,
              span.begin, span.end),
          Place(path, curve->rows[after].line));
    }
    times.push_back(time);
  }
  return times;
}

}  // namespace t4d::tools
