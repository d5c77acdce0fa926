#include "formats/t4d/body_details.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace t4d::formats {
namespace {

using nlohmann::ordered_json;

constexpr const char* kLink = "link";
constexpr const char* kChordBound = "chord_bound";
constexpr const char* kMended = "mended";
constexpr const char* kJoints = "joints";

ordered_json detailsOf(const BodyInfo& body) {
  auto details = ordered_json::parse(body.detailsJson, nullptr, /*allow_exceptions=*/false);
  return details.is_object() ? details : ordered_json::object();
}

void set(BodyInfo& body, const char* key, const ordered_json& value) {
  ordered_json details = detailsOf(body);
  details[key] = value;
  body.detailsJson = details.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace

std::string linkOf(const BodyInfo& body) {
  const ordered_json details = detailsOf(body);
  const auto link = details.find(kLink);
  return link != details.end() && link->is_string() ? link->get<std::string>() : body.name;
}

void setLink(BodyInfo& body, const std::string& link) { set(body, kLink, link); }

std::optional<double> chordBoundOf(const BodyInfo& body) {
  const ordered_json details = detailsOf(body);
  const auto bound = details.find(kChordBound);
  if (bound == details.end() || !bound->is_number() || !(bound->get<double>() >= 0)) return {};
  return bound->get<double>();
}

void setChordBound(BodyInfo& body, double bound) { set(body, kChordBound, bound); }

double JointCourse::at(double time) const {
  const auto after = std::ranges::upper_bound(times, time);
  if (after == times.begin()) return values.front();
  if (after == times.end()) return values.back();
  const auto i = static_cast<std::size_t>(after - times.begin());
  const double part = (time - times[i - 1]) / (times[i] - times[i - 1]);
  return (1 - part) * values[i - 1] + part * values[i];
}

std::vector<JointCourse> jointsOf(const std::string& detailsJson) {
  const auto details = ordered_json::parse(detailsJson, nullptr, /*allow_exceptions=*/false);
  if (!details.is_object() || !details.contains(kJoints)) return {};
  try {
    std::vector<JointCourse> joints;
    for (const ordered_json& joint : details[kJoints]) {
      joints.push_back({joint.at("name"), joint.at("unit"), joint.at("times"), joint.at("values")});
      const auto& [name, unit, times, values] = joints.back();
      if (times.empty() || times.size() != values.size()) return {};
      if (!std::ranges::is_sorted(times)) return {};
    }
    return joints;
  } catch (const ordered_json::exception&) {
    return {};  // another program's member
  }
}

std::string jointsJson(const std::vector<JointCourse>& joints) {
  ordered_json all = ordered_json::array();
  for (const auto& [name, unit, times, values] : joints) {
    all.push_back({{"name", name}, {"unit", unit}, {"times", times}, {"values", values}});
  }
  return all.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

std::optional<MendedInfo> mendedInfoOf(const BodyInfo& body) {
  const ordered_json details = detailsOf(body);
  const auto mended = details.find(kMended);
  if (mended == details.end() || !mended->is_object()) return {};
  const auto number = [&](const char* key) -> std::optional<double> {
    const auto found = mended->find(key);
    if (found == mended->end() || !found->is_number()) return {};
    return found->get<double>();
  };
  const auto after = number("volume_after");
  if (!after) return {};
  MendedInfo info{number("volume_before"), *after, number("hausdorff").value_or(0), 0,
                  number("lost_distance").value_or(0)};
  const auto lost = mended->find("lost_triangles");
  if (lost != mended->end() && lost->is_number_unsigned()) {
    info.lostTriangles = lost->get<std::uint64_t>();
  }
  info.hull = mended->value("hull", ordered_json()) == true;
  return info;
}

void setMendedInfo(BodyInfo& body, const MendedInfo& info) {
  set(body, kMended,
      {{"volume_before", info.volumeBefore ? ordered_json(*info.volumeBefore) : ordered_json()},
       {"volume_after", info.volumeAfter},
       {"hausdorff", info.hausdorff},
       {"lost_triangles", info.lostTriangles},
       {"lost_distance", info.lostDistance},
       {"hull", info.hull}});
}

}  // namespace t4d::formats
