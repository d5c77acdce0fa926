#include "formats/text/json_check.h"

#include <algorithm>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace t4d::formats {
namespace {

using nlohmann::json;

/// A false result ends the parsing.
class JsonCheck : public nlohmann::json_sax<json> {
 public:
  JsonCheck(const Place& name, const JsonRules& rules) : name_(name), rules_(rules) {}

  Result<void> result() const {
    return problem_.empty() ? Result<void>() : invalid(problem_, name_);
  }

  bool null() override { return scalar("null"); }
  bool boolean(bool value) override { return scalar(value ? "true" : "false"); }
  bool number_integer(std::int64_t value) override { return scalar(fmt::format("{}", value)); }
  bool number_unsigned(std::uint64_t) override { return forget(); }
  bool number_float(double value, const std::string&) override {
    return scalar(fmt::format("{}", value));
  }
  bool string(std::string&) override { return scalar("text"); }
  bool binary(json::binary_t&) override { return true; }
  bool start_object(std::size_t) override { return open(true); }
  bool start_array(std::size_t) override { return open(false); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(std::string& key) override {
    if (!open_.back().insert(key).second) {
      return refuse(fmt::format("has the key '{}' twice in one object", key));
    }
    key_ = key;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }

 private:
  bool refuse(std::string problem) {
    problem_ = std::move(problem);
    return false;
  }
  bool forget() {
    key_.clear();
    return true;
  }
  bool scalar(std::string_view found) {
    if (std::ranges::find(rules_.wholeNumbers, key_) != rules_.wholeNumbers.end()) {
      return refuse(
          fmt::format("has a '{}' of {}, expected a whole number from 0 on", key_, found));
    }
    return forget();
  }
  bool open(bool isObject) {
    if (!scalar(isObject ? "an object" : "an array")) return false;
    if (static_cast<int>(open_.size()) == rules_.deepestNesting) {
      return refuse(fmt::format("has JSON nested more than {} levels deep", rules_.deepestNesting));
    }
    open_.emplace_back();
    return true;
  }
  bool close() {
    open_.pop_back();
    return forget();
  }

  const Place& name_;
  const JsonRules& rules_;
  std::vector<std::set<std::string>> open_;  // the keys so far of each open object
  std::string key_;                          // whose value comes next; "" in arrays
  std::string problem_;
};

}  // namespace

Result<void> checkJson(std::string_view text, const Place& name, const JsonRules& rules) {
  JsonCheck check(name, rules);
  json::sax_parse(text, &check);
  return check.result();
}

}  // namespace t4d::formats
