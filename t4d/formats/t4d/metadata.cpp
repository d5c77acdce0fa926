#include "t4d/formats/t4d/metadata.h"

#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/t4d/layout.h"

namespace t4d::formats {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// Parses a JSON object and limits its nesting: code that handles JSON recurses, here and
/// elsewhere, and could overflow the stack.
Result<Json> parseObject(const std::string& text) {
  bool tooDeep = false;
  const Json::parser_callback_t check = [&](int depth, Json::parse_event_t event, Json&) {
    const bool opens =
        event == Json::parse_event_t::object_start || event == Json::parse_event_t::array_start;
    if (opens && depth >= t4d_layout::kMaxJsonDepth) tooDeep = true;
    return !tooDeep;
  };
  const auto wrongAt = [](std::size_t byte) {
    Error error{ErrorCode::InvalidInput,
                fmt::format("is not a JSON object: byte {} of it is wrong", byte),
                {}};
    error.offset = byte;
    return pass(std::move(error));
  };
  // The parser would treat a zero byte as the end of the text.
  if (const auto zero = text.find('\0'); zero != std::string::npos) return wrongAt(zero);
  Json json;
  try {
    json = Json::parse(text, check);
  } catch (const Json::parse_error& error) {
    return wrongAt(error.byte > 0 ? error.byte - 1 : 0);
  } catch (const Json::exception&) {
    return invalid("has a number that binary64 cannot hold");
  }
  if (tooDeep || !json.is_object()) {
    return invalid(
        fmt::format("is not a JSON object of at most {} levels", t4d_layout::kMaxJsonDepth));
  }
  return json;
}

Result<std::vector<std::string>> namesOf(const Json& head, const char* key) {
  const auto found = head.find(key);
  if (found == head.end() || !found->is_array()) {
    return invalid(fmt::format("its metadata has no array '{}'", key));
  }
  std::vector<std::string> names;
  for (const Json& name : *found) {
    if (!name.is_string()) {
      return invalid(fmt::format("its metadata has a '{}' entry that is not a string", key));
    }
    names.push_back(name.get<std::string>());
  }
  return names;
}

Result<void> checkBodies(const std::vector<std::string>& names) {
  if (names.empty() || names.size() > t4d_layout::kMaxBodies) {
    return invalid(fmt::format("its metadata names {} bodies; 1 to {} are allowed", names.size(),
                               t4d_layout::kMaxBodies));
  }
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.empty() || name.size() > t4d_layout::kMaxNameBytes) {
      return invalid(fmt::format("its metadata has a body name of {} bytes; 1 to {} are allowed",
                                 name.size(), t4d_layout::kMaxNameBytes));
    }
    if (!seen.insert(name).second) {
      return invalid(fmt::format("its metadata names the body '{}' twice", name));
    }
  }
  return {};
}

}  // namespace

Result<std::string> headText(const Metadata& metadata, const std::vector<std::string>& features) {
  const auto details = parseObject(metadata.detailsJson);
  if (!details) return invalid("what is to be 'details' " + details.error().message);
  Json head;
  head["features"] = features;
  head["bodies"] = metadata.bodies;
  const auto optional = [&](const char* key, const std::string& value) {
    if (!value.empty()) head[key] = value;
  };
  optional("generator", metadata.generator);
  optional("backend", metadata.backend);
  optional("length_unit", metadata.lengthUnit);
  optional("time_unit", metadata.timeUnit);
  optional("up", metadata.up);
  if (!details->empty()) head["details"] = *details;
  std::string text = head.dump(1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > t4d_layout::kMaxHeadBytes) {
    return invalid(fmt::format("the metadata has {} bytes; at most {} are allowed", text.size(),
                               t4d_layout::kMaxHeadBytes));
  }
  return text;
}

Result<Metadata> parseHead(const std::string& text) {
  if (text.starts_with(kByteOrderMark)) {
    return invalid("its metadata begins with a byte order mark");
  }
  const auto parsed = parseObject(text);
  if (!parsed) {
    Error error = parsed.error();
    error.message = "its metadata " + error.message;
    return pass(std::move(error));
  }
  const Json& head = *parsed;
  auto features = namesOf(head, "features");
  if (!features) return pass(features.error());
  for (const std::string& feature : *features) {
    if (feature != t4d_layout::kFeatureZstd && feature != t4d_layout::kFeatureMeans) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("it needs the feature '{}', which this version does not know; a newer "
                      "t4d may",
                      feature));
    }
  }
  Metadata metadata;
  metadata.features = std::move(*features);
  auto bodies = namesOf(head, "bodies");
  if (!bodies) return pass(bodies.error());
  metadata.bodies = std::move(*bodies);
  if (auto checked = checkBodies(metadata.bodies); !checked) return pass(checked.error());

  Error wrong;
  const auto optional = [&](const char* key, std::string& into) {
    const auto found = head.find(key);
    if (found == head.end()) return;
    if (found->is_string()) {
      into = found->get<std::string>();
    } else {
      wrong = Error{
          ErrorCode::InvalidInput, fmt::format("its metadata's '{}' is not a string", key), {}};
    }
  };
  optional("generator", metadata.generator);
  optional("backend", metadata.backend);
  optional("length_unit", metadata.lengthUnit);
  optional("time_unit", metadata.timeUnit);
  optional("up", metadata.up);
  if (!wrong.message.empty()) return pass(wrong);
  if (metadata.up != "y" && metadata.up != "z") {
    return invalid(fmt::format("its metadata's 'up' is '{}', not 'y' or 'z'", metadata.up));
  }
  if (const auto details = head.find("details"); details != head.end()) {
    if (!details->is_object()) return invalid("its metadata's 'details' is not an object");
    metadata.detailsJson = details->dump();
  }
  return metadata;
}

}  // namespace t4d::formats
