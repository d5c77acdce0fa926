#include "formats/toolpath/gcode_parameters.h"

#include <cmath>

#include <fmt/format.h>

namespace t4d::formats {
namespace {

// From here to 5602 are those of the control.
constexpr int kFirstOfControl = 5001;

Result<int> parameterNumber(double number) {
  if (!(std::abs(number - std::round(number)) < 1e-4) || !(number > 0.5) ||
      !(number < GcodeParameters::kMost + 0.5)) {
    return invalid(fmt::format("#{:g} is not a parameter: they have the numbers 1 to {}", number,
                               GcodeParameters::kMost));
  }
  return static_cast<int>(std::round(number));
}

}  // namespace

Result<double> GcodeParameters::value(double number) const {
  const auto key = parameterNumber(number);
  if (!key) return key.error();
  if (*key >= kFirstOfControl) {
    if (const auto known = control_.numbered(*key)) return *known;
    return fail(ErrorCode::Unsupported,
                fmt::format("#{} is not supported: it is a value of the control that is not "
                            "known here, or not yet",
                            *key));
  }
  const auto at = [&](const auto& values) {
    const auto found = values.find(*key);
    return found == values.end() ? 0 : found->second;
  };
  return *key <= static_cast<int>(kArguments) ? at(frames_.back().numbered) : at(numbered_);
}

const std::map<std::string, double>& GcodeParameters::namesOf(const std::string& name) const {
  return name.starts_with('_') ? global_ : frames_.back().named;
}

bool GcodeParameters::exists(double number) const {
  const auto key = parameterNumber(number);
  if (!key) return false;
  if (*key >= kFirstOfControl) return control_.numbered(*key).has_value();
  return *key <= static_cast<int>(kArguments) ? frames_.back().numbered.contains(*key)
                                              : numbered_.contains(*key);
}

bool GcodeParameters::exists(const std::string& name) const {
  return namesOf(name).contains(name) || control_.named(name).has_value();
}

Result<double> GcodeParameters::value(const std::string& name) const {
  if (const auto known = control_.named(name)) return *known;
  const auto& names = namesOf(name);
  const auto found = names.find(name);
  if (found != names.end()) return found->second;
  return invalid(fmt::format("#<{}> has not been set", name));
}

Result<void> GcodeParameters::set(double number, double value) {
  const auto key = parameterNumber(number);
  if (!key) return key.error();
  if (*key >= kFirstOfControl) {
    return fail(ErrorCode::Unsupported,
                fmt::format("#{} cannot be set: it is a value of the control; offsets are set by "
                            "G10 and G92",
                            *key),
                {}, Remedy::Origin);
  }
  if (*key <= static_cast<int>(kArguments)) {
    frames_.back().numbered[*key] = value;
  } else {
    numbered_[*key] = value;
  }
  return {};
}

Result<void> GcodeParameters::set(const std::string& name, double value) {
  if (control_.named(name)) return invalid(fmt::format("#<{}> is a value of the control", name));
  (name.starts_with('_') ? global_ : frames_.back().named)[name] = value;
  return {};
}

void GcodeParameters::enter(std::map<int, double> arguments) {
  frames_.push_back({std::move(arguments), {}});
}

}  // namespace t4d::formats
