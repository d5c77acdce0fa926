#include "t4d/formats/t4d/body_details.h"

#include <nlohmann/json.hpp>

namespace t4d::formats {
namespace {

using nlohmann::ordered_json;

constexpr const char* kLink = "link";
constexpr const char* kChordBound = "chord_bound";

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

}  // namespace t4d::formats
