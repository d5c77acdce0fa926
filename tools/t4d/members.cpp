#include "tools/t4d/members.h"

#include "platform/process.h"

namespace t4d::tools {

using nlohmann::ordered_json;

Member& Member::limit(const char* keyword, const ordered_json& value) {
  if (all_.what_ == Members::Of::Schema) all_.json_["properties"][name_][keyword] = value;
  return *this;
}

Member& Member::oneOf(const std::vector<std::string>& words) {
  if (all_.what_ != Members::Of::Schema) return *this;
  ordered_json& schema = all_.json_["properties"][name_];
  const bool isNullable = schema["type"].is_array();
  schema.erase("type");
  schema["enum"] = words;
  if (isNullable) schema["enum"].push_back(nullptr);
  return *this;
}

Member& Member::orNull() {
  if (all_.what_ != Members::Of::Schema) return *this;
  ordered_json& type = all_.json_["properties"][name_]["type"];
  if (!type.is_array()) type = {type, "null"};
  return *this;
}

Member& Member::nullIf(bool unknown) {
  if (unknown && all_.what_ == Members::Of::Values) all_.json_[name_] = nullptr;
  return orNull();
}

Member& Member::itemsOrNull() {
  if (all_.what_ != Members::Of::Schema) return *this;
  ordered_json& type = all_.json_["properties"][name_]["items"]["type"];
  type = {type, "null"};
  return *this;
}

Member& Member::onlyIf(bool present) {
  if (all_.what_ == Members::Of::Values) {
    if (!present) all_.json_.erase(name_);
    return *this;
  }
  ordered_json& required = all_.json_["required"];
  std::erase(required.get_ref<ordered_json::array_t&>(), ordered_json(name_));
  return *this;
}

Member& Member::joined(Joined rule) {
  all_.rules_[name_] = rule;
  return *this;
}

void Members::addSchema(const char* name, ordered_json schema, const char* meaning) {
  if (json_.empty()) {
    json_ = {{"type", "object"},
             {"properties", ordered_json::object()},
             {"required", ordered_json::array()},
             {"additionalProperties", false}};
  }
  schema["description"] = meaning;
  json_["properties"][name] = std::move(schema);
  json_["required"].push_back(name);
}

void addCosts(Members& members, double seconds) {
  members("seconds", seconds, "Time it took, in seconds.").atLeast(0).joined(Joined::Added);
  members("peak_bytes", platform::peakBytes(), "The most memory that the program had, in bytes.")
      .joined(Joined::Most);
}

}  // namespace t4d::tools
