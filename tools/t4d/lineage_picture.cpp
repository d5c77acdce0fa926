#include "tools/t4d/lineage_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "tools/report/html_page.h"
#include "tools/t4d/slice_tracks.h"

namespace t4d::tools {
namespace {

using measure::Track;
using measure::TrackEvent;
using measure::TrackEventKind;

// Pixels from the top left.
constexpr double kWidth = 900;
constexpr double kLeft = 60;
constexpr double kRight = 880;
constexpr double kTop = 20;
constexpr double kLane = 26;
constexpr double kThickest = 20;
constexpr double kThinnest = 1;
constexpr double kTickHeight = 6;
constexpr int kTicks = 8;

/// The lanes of tracks in the picture.
struct Lanes {
  std::vector<std::size_t> ofTrack;
  std::size_t count = 0;
};

/// A track takes the lane of one that it comes out of, if it is the first to do so, or else the
/// first that is free.
Lanes lanesOf(const std::vector<Track>& tracks, std::size_t first) {
  Lanes lanes{std::vector<std::size_t>(tracks.size(), 0), first};
  std::vector<double> free;  // from when on, each
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Track& track = tracks[i];
    std::size_t lane = free.size();
    for (const std::uint32_t from : track.from) {
      const std::size_t own = lanes.ofTrack[from] - first;
      if (free[own] <= track.begin) lane = std::min(lane, own);
    }
    for (std::size_t k = 0; lane == free.size() && k < free.size(); ++k) {
      if (free[k] < track.begin) lane = k;
    }
    if (lane == free.size()) free.push_back(0);
    free[lane] = track.end;
    lanes.ofTrack[i] = first + lane;
  }
  lanes.count = first + free.size();
  return lanes;
}

std::string_view colourOf(TrackEventKind kind) {
  switch (kind) {
    case TrackEventKind::Appears:
      return "#1a7f37";
    case TrackEventKind::Vanishes:
      return "#b42318";
    case TrackEventKind::HoleOpens:
    case TrackEventKind::HoleCloses:
      return "#b26b00";
    case TrackEventKind::Splits:
    case TrackEventKind::Merges:
    case TrackEventKind::Rearranges:
      return "#24292f";
    default:
      return "#6e40c9";
  }
}

/// A linear colour in sRGB, as #rrggbb.
std::string hexOf(const formats::Color& color) {
  std::string hex = "#";
  for (int i = 0; i < 3; ++i) {
    const double linear = color[i];
    const double value =
        linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    hex += fmt::format("{:02x}", std::lround(255 * value));
  }
  return hex;
}

}  // namespace

std::string lineagePicture(const TrackReport& report) {
  double begin = std::numeric_limits<double>::infinity();
  double end = -begin;
  double largest = 0;
  for (const BodyTracks& body : report.bodies) {
    begin = std::min(begin, body.tracks.time.begin);
    end = std::max(end, body.tracks.time.end);
    for (const Track& track : body.tracks.tracks) largest = std::max(largest, track.largestVolume);
  }
  const auto x = [&](double time) {
    return end > begin ? kLeft + (kRight - kLeft) * (time - begin) / (end - begin) : kLeft;
  };
  const auto y = [](std::size_t lane) { return kTop + kLane * (static_cast<double>(lane) + 0.5); };
  const auto half = [&](double volume) {
    const double part = largest > 0 ? std::abs(volume) / largest : 0;
    return std::max(kThinnest, kThickest * part) / 2;
  };
  std::string bands;
  std::string links;
  std::string marks;
  std::size_t lane = 0;
  for (const BodyTracks& body : report.bodies) {
    const std::vector<Track>& tracks = body.tracks.tracks;
    const Lanes lanes = lanesOf(tracks, lane);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const Track& track = tracks[i];
      const double middle = y(lanes.ofTrack[i]);
      std::vector<std::pair<double, double>> edge;  // x and half the thickness
      for (const measure::TrackSample& sample : track.samples) {
        edge.emplace_back(x(sample.measures.time), half(sample.measures.volume));
      }
      const double first = edge.empty() ? half(track.largestVolume) : edge.front().second;
      const double last = edge.empty() ? first : edge.back().second;
      const bool appears = track.from.empty() && !track.beginsWithMesh;
      const bool vanishes = track.into.empty() && !track.endsWithMesh;
      edge.insert(edge.begin(), {x(track.begin), appears ? kThinnest / 2 : first});
      edge.emplace_back(x(track.end), vanishes ? kThinnest / 2 : last);
      std::string points;
      for (const auto& [at, thick] : edge)
        points += fmt::format("{:.2f},{:.2f} ", at, middle - thick);
      for (auto at = edge.rbegin(); at != edge.rend(); ++at) {
        points += fmt::format("{:.2f},{:.2f} ", at->first, middle + at->second);
      }
      bands += fmt::format(
          "<polygon fill=\"{}\" points=\"{}\"><title>{}</title></polygon>\n",
          hexOf(trackColor(body.firstId + i)), points,
          escaped(fmt::format("{}{}, {:g} to {:g}", body.firstId + i,
                              body.name.empty() ? "" : " " + body.name, track.begin, track.end)));
      for (const std::uint32_t into : track.into) {
        links += fmt::format(
            "<line stroke=\"#57606a\" x1=\"{0:.2f}\" y1=\"{1:.2f}\" x2=\"{0:.2f}\" "
            "y2=\"{2:.2f}\"/>\n",
            x(track.end), middle, y(lanes.ofTrack[into]));
      }
    }
    for (const TrackEvent& event : body.tracks.events) {
      const auto& with = event.after.empty() ? event.before : event.after;
      if (with.empty()) continue;
      marks += fmt::format(
          "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"3.5\" fill=\"{}\"><title>{}</title></circle>\n",
          x(event.time), y(lanes.ofTrack[with.front()]), colourOf(event.kind),
          escaped(fmt::format("{} at {:g}", nameOf(event.kind), event.time)));
    }
    lane = lanes.count;
  }
  const double bottom = kTop + kLane * static_cast<double>(std::max<std::size_t>(lane, 1));
  std::string axis =
      fmt::format("<line stroke=\"#57606a\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>\n", kLeft,
                  bottom, kRight, bottom);
  for (int i = 0; i <= kTicks && end > begin; ++i) {
    const double time = begin + (end - begin) * i / kTicks;
    axis += fmt::format(
        "<line stroke=\"#57606a\" x1=\"{0:.2f}\" y1=\"{1}\" x2=\"{0:.2f}\" y2=\"{2}\"/>\n"
        "<text x=\"{0:.2f}\" y=\"{3}\" font-size=\"11\" text-anchor=\"middle\">{4:.4g}</text>\n",
        x(time), bottom, bottom + kTickHeight, bottom + 3 * kTickHeight, time);
  }
  const double height = bottom + 44;
  return fmt::format(
      "<svg viewBox=\"0 0 {0:g} {1:g}\" width=\"{0:g}\" height=\"{1:g}\">\n{2}{3}{4}{5}"
      "<text x=\"{6}\" y=\"{7:g}\" font-size=\"11\" text-anchor=\"middle\">{8}</text>\n</svg>\n",
      kWidth, height, axis, links, bands, marks, (kLeft + kRight) / 2, height - 8,
      escaped(labelled("time", report.timeUnit)));
}

}  // namespace t4d::tools
