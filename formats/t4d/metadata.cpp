#include "formats/t4d/metadata.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/layout.h"
#include "formats/t4d/names.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

using Json = nlohmann::json;

constexpr std::array kHeadMembers = {"features",  "bodies", "generator", "backend", "length_unit",
                                     "time_unit", "up",     "grid",      "details"};
constexpr std::array kBodyMembers = {"name", "color", "material", "parent", "details"};
constexpr std::array kSpaces = {"RAS", "LPS"};

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// The depth of the brackets outside of strings.
int nestingOf(std::string_view text) {
  int depth = 0;
  int most = 0;
  bool inString = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') inString = !inString;
    if (inString) {
      if (c == '\\') ++i;
    } else if (c == '{' || c == '[') {
      most = std::max(most, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return most;
}

/// Parses a JSON object and limits its nesting: code that handles JSON recurses, here and
/// elsewhere, and could overflow the stack. The parser itself could look at the nesting, but takes
/// time with the square of the number of objects then.
Result<Json> parseObject(const std::string& text) {
  const auto wrongAt = [](std::size_t byte) {
    Error error{ErrorCode::InvalidInput,
                fmt::format("is not a JSON object: byte {} of it is wrong", byte),
                {}};
    error.offset = byte;
    return error;
  };
  // The parser would treat a zero byte as the end of the text.
  if (const auto zero = text.find('\0'); zero != std::string::npos) return wrongAt(zero);
  const bool tooDeep = nestingOf(text) > t4d_layout::kMaxJsonDepth;
  Json json;
  try {
    if (!tooDeep) json = Json::parse(text);
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

/// An object without the members of these names.
template <class Names>
std::string withoutMembers(Json object, const Names& names) {
  for (const char* name : names) object.erase(name);
  return object.dump();
}

bool isSpace(const std::string& text) { return std::ranges::find(kSpaces, text) != kSpaces.end(); }

/// What an entry of `attributes` says; nothing if it is not of the right form.
std::optional<model::AttributeMeaning> meaningFrom(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  model::AttributeMeaning meaning;
  for (const auto& [key, into] : {std::pair{"kind", &meaning.kind}, {"unit", &meaning.unit}}) {
    const auto found = json.find(key);
    if (found == json.end()) continue;
    if (!found->is_string()) return std::nullopt;
    *into = found->get<std::string>();
  }
  meaning.otherJson = withoutMembers(json, std::array{"kind", "unit"});
  return meaning;
}

/// Parses `attributes`, which must have at least one member.
std::optional<model::AttributeMeanings> meaningsFrom(const Json& json) {
  if (!json.is_object() || json.empty()) return std::nullopt;
  model::AttributeMeanings meanings;
  for (const auto& [name, entry] : json.items()) {
    auto meaning = meaningFrom(entry);
    if (!meaning) return std::nullopt;
    meanings.emplace(name, std::move(*meaning));
  }
  return meanings;
}

/// Checks what can be checked of each body alone.
Result<BodyInfo> bodyOf(const Json& json) {
  const auto wrong = [](const char* key, const char* what) {
    return invalid(fmt::format("its metadata has a body whose '{}' is not {}", key, what));
  };
  if (!json.is_object()) return invalid("its metadata has a 'bodies' entry that is not an object");
  BodyInfo body;
  const auto name = json.find("name");
  if (name == json.end() || !name->is_string()) return wrong("name", "a string");
  body.name = name->get<std::string>();
  if (auto checked = checkName(body.name); !checked) {
    return invalid("its metadata has a body name that " + checked.error().message);
  }
  for (const auto& [key, into] :
       {std::pair{"material", &body.material}, {"parent", &body.parent}}) {
    const auto found = json.find(key);
    if (found == json.end()) continue;
    if (!found->is_string()) return wrong(key, "a string");
    *into = found->get<std::string>();
  }
  if (const auto color = json.find("color"); color != json.end()) {
    const auto inRange = [](const Json& number) {
      return number.is_number() && number.get<double>() >= 0 && number.get<double>() <= 1;
    };
    if (!color->is_array() || color->size() < 3 || color->size() > 4 ||
        !std::all_of(color->begin(), color->end(), inRange)) {
      return wrong("color", "3 or 4 numbers from 0 to 1");
    }
    body.color = color->get<std::vector<double>>();
  }
  if (const auto details = json.find("details"); details != json.end()) {
    if (!details->is_object()) return wrong("details", "an object");
    body.detailsJson = details->dump();
  }
  if (json.contains("parent") && body.parent.empty()) return wrong("parent", "another body");
  body.otherJson = withoutMembers(json, kBodyMembers);
  return body;
}

Result<std::vector<BodyInfo>> bodiesOf(const Json& head) {
  const auto found = head.find("bodies");
  if (found == head.end() || !found->is_array())
    return invalid("its metadata has no array 'bodies'");
  if (found->empty() || found->size() > t4d_layout::kMaxBodies) {
    return invalid(fmt::format("its metadata names {} bodies; 1 to {} are allowed", found->size(),
                               t4d_layout::kMaxBodies));
  }
  std::vector<BodyInfo> bodies;
  std::map<std::string, std::size_t> numbers;
  for (const Json& json : *found) {
    auto body = bodyOf(json);
    if (!body) return body.error();
    if (!numbers.emplace(body->name, bodies.size()).second) {
      return invalid(fmt::format("its metadata names the body '{}' twice", body->name));
    }
    bodies.push_back(std::move(*body));
  }
  // Parents form a forest: going up from any body ends within as many steps as there are bodies. A
  // path is followed once only.
  std::vector<bool> rooted(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    std::vector<std::size_t> path;
    for (std::size_t at = i; !rooted[at];) {
      path.push_back(at);
      if (bodies[at].parent.empty()) break;
      const auto parent = numbers.find(bodies[at].parent);
      if (parent == numbers.end() || path.size() > bodies.size()) {
        return invalid(fmt::format("its metadata has a body '{}' whose 'parent' is {}",
                                   bodies[i].name,
                                   parent == numbers.end() ? "no body" : "a part of itself"));
      }
      at = parent->second;
    }
    for (const std::size_t at : path) rooted[at] = true;
  }
  return bodies;
}

Result<std::optional<Grid>> gridOf(const Json& head, const std::vector<std::string>& features) {
  const auto wrong = [](const char* what) {
    return invalid(fmt::format("its metadata's 'grid' is not {}", what));
  };
  const auto found = head.find("grid");
  if (found == head.end()) {
    if (std::ranges::find(features, t4d_layout::kFeatureGrid) == features.end()) {
      return std::nullopt;
    }
    return wrong("there, though it names the feature");
  }
  const auto isFinite = [](const Json& json) {
    return json.is_number() && std::isfinite(json.get<double>());
  };
  if (!found->is_object()) return wrong("an object");
  const auto origin = found->find("origin");
  if (origin == found->end() || !origin->is_array() || origin->size() != 3 ||
      !std::ranges::all_of(*origin, isFinite)) {
    return wrong("an object whose 'origin' is three finite numbers");
  }
  const auto step = found->find("step");
  if (step == found->end() || !isFinite(*step) || !(step->get<double>() > 0)) {
    return wrong("an object whose 'step' is a positive number");
  }
  return Grid{{(*origin)[0].get<double>(), (*origin)[1].get<double>(), (*origin)[2].get<double>()},
              step->get<double>()};
}

Result<Json> jsonOf(const BodyInfo& body) {
  const auto others = parseObject(body.otherJson);
  if (!others) return invalid("what is to be members of a body " + others.error().message);
  Json json = *others;
  json["name"] = body.name;
  if (!body.color.empty()) json["color"] = body.color;
  if (!body.material.empty()) json["material"] = body.material;
  if (!body.parent.empty()) json["parent"] = body.parent;
  const auto details = parseObject(body.detailsJson);
  if (!details) return invalid("what is to be a body's 'details' " + details.error().message);
  if (!details->empty()) json["details"] = *details;
  return json;
}

Result<Json> jsonOf(const model::AttributeMeanings& meanings) {
  Json json = Json::object();
  for (const auto& [name, meaning] : meanings) {
    const auto others = parseObject(meaning.otherJson);
    if (!others) return invalid("what is to be members of an attribute " + others.error().message);
    Json& entry = json[name] = *others;
    if (!meaning.kind.empty()) entry["kind"] = meaning.kind;
    if (!meaning.unit.empty()) entry["unit"] = meaning.unit;
  }
  return json;
}

}  // namespace

std::uint16_t minorVersionFor(const Metadata& metadata) {
  return metadata.space.empty() && metadata.attributes.empty() ? 0 : 1;
}

Result<std::string> headText(const Metadata& metadata, const std::vector<std::string>& features,
                             const std::optional<Grid>& grid) {
  const auto details = parseObject(metadata.detailsJson);
  if (!details) return invalid("what is to be 'details' " + details.error().message);
  const auto others = parseObject(metadata.otherJson);
  if (!others) return invalid("what is to be further members " + others.error().message);
  Json head = *others;
  head["features"] = features;
  head["bodies"] = Json::array();
  for (const BodyInfo& body : metadata.bodies) {
    auto json = jsonOf(body);
    if (!json) return json.error();
    head["bodies"].push_back(std::move(*json));
  }
  const auto optional = [&](const char* key, const std::string& value) {
    if (!value.empty()) head[key] = value;
  };
  optional("generator", metadata.generator);
  optional("backend", metadata.backend);
  optional("length_unit", metadata.lengthUnit);
  optional("time_unit", metadata.timeUnit);
  optional("up", metadata.up);
  if (grid) {
    head["grid"] = {{"origin", {grid->origin[0], grid->origin[1], grid->origin[2]}},
                    {"step", grid->step}};
  }
  if (!metadata.space.empty() && !isSpace(metadata.space)) {
    return invalid(fmt::format("the space is '{}'; it can be 'RAS' or 'LPS'", metadata.space));
  }
  optional("space", metadata.space);
  if (!metadata.attributes.empty()) {
    auto attributes = jsonOf(metadata.attributes);
    if (!attributes) return attributes.error();
    head["attributes"] = std::move(*attributes);
  }
  if (!details->empty()) head["details"] = *details;
  std::string text = head.dump(1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > t4d_layout::kMaxHeadBytes) {
    return invalid(fmt::format("the metadata has {} bytes; at most {} are allowed", text.size(),
                               t4d_layout::kMaxHeadBytes));
  }
  return text;
}

namespace {

/// The members that all objects with a member of this name agree on.
std::string agreedMembers(const std::vector<std::string>& objects, const std::string& where,
                          std::vector<std::string>& lost) {
  Json agreed = Json::object();
  std::set<std::string> differing;
  for (const std::string& text : objects) {
    const Json object = Json::parse(text);
    for (const auto& [name, value] : object.items()) {
      if (agreed.emplace(name, value).first.value() != value) differing.insert(name);
    }
  }
  for (const std::string& name : differing) {
    agreed.erase(name);
    lost.push_back(fmt::format("member '{}' of {}: the files differ in it", name, where));
  }
  return agreed.dump();
}

}  // namespace

Metadata joinedMetadata(const std::vector<const Metadata*>& files, std::vector<std::string>& lost) {
  Metadata joined = *files.front();
  const auto agree = [&](auto membersOf, const std::string& where) {
    std::vector<std::string> objects;
    for (const Metadata* file : files) objects.push_back(membersOf(*file));
    return agreedMembers(objects, where, lost);
  };
  joined.otherJson = agree([](const Metadata& file) { return file.otherJson; }, "the metadata");
  for (std::size_t i = 0; i < joined.bodies.size(); ++i) {
    joined.bodies[i].otherJson =
        agree([i](const Metadata& file) { return file.bodies[i].otherJson; },
              fmt::format("the body '{}'", joined.bodies[i].name));
  }
  for (const Metadata* file : files) {
    joined.attributes.insert(file->attributes.begin(), file->attributes.end());
  }
  // Some of them may have `attributes` of another form.
  Json others = Json::parse(joined.otherJson);
  const auto unread = others.find("attributes");
  if (!joined.attributes.empty() && unread != others.end()) {
    if (*unread != Json::object()) {
      lost.emplace_back("member 'attributes' of the metadata: the files differ in it");
    }
    others.erase(unread);
    joined.otherJson = others.dump();
  }
  return joined;
}

Result<Metadata> parseHead(const std::string& text) {
  if (text.starts_with(kByteOrderMark)) {
    return invalid("its metadata begins with a byte order mark");
  }
  const auto parsed = parseObject(text);
  if (!parsed) {
    Error error = parsed.error();
    error.message = "its metadata " + error.message;
    return error;
  }
  const Json& head = *parsed;
  auto features = namesOf(head, "features");
  if (!features) return features.error();
  for (const std::string& feature : *features) {
    if (std::ranges::find(t4d_layout::kFeatures, feature) == t4d_layout::kFeatures.end()) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("it needs the feature '{}', which this version does not know; a newer "
                      "t4d may",
                      feature));
    }
  }
  Metadata metadata;
  metadata.features = std::move(*features);
  auto bodies = bodiesOf(head);
  if (!bodies) return bodies.error();
  metadata.bodies = std::move(*bodies);
  auto grid = gridOf(head, metadata.features);
  if (!grid) return grid.error();
  metadata.grid = *grid;

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
  if (!wrong.message.empty()) return wrong;
  if (metadata.up != "y" && metadata.up != "z") {
    return invalid(fmt::format("its metadata's 'up' is '{}', not 'y' or 'z'", metadata.up));
  }
  if (const auto details = head.find("details"); details != head.end()) {
    if (!details->is_object()) return invalid("its metadata's 'details' is not an object");
    metadata.detailsJson = details->dump();
  }
  Json others = head;
  if (const auto space = head.find("space");
      space != head.end() && space->is_string() && isSpace(space->get<std::string>())) {
    metadata.space = space->get<std::string>();
    others.erase("space");
  }
  if (const auto attributes = head.find("attributes"); attributes != head.end()) {
    if (auto meanings = meaningsFrom(*attributes)) {
      metadata.attributes = std::move(*meanings);
      others.erase("attributes");
    }
  }
  metadata.otherJson = withoutMembers(std::move(others), kHeadMembers);
  return metadata;
}

}  // namespace t4d::formats
