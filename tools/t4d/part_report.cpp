#include "tools/t4d/part_report.h"

#include <fmt/format.h>

#include "platform/crc32c.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

constexpr const char* kPart = "part";
constexpr const char* kChecksums = "checksums";

/// The order of members does not count, nor does the layout of the text.
std::string checksumOf(const ordered_json& value) {
  const std::string text =
      nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return fmt::format("{:08x}", platform::crc32c(text.data(), text.size()));
}

ordered_json checksumsOf(const ordered_json& report) {
  auto checksums = ordered_json::object();
  for (const auto& [name, value] : report.items()) {
    if (name != kPart) {
      checksums[name] = checksumOf(value);
      continue;
    }
    ordered_json part = value;
    part.erase(kChecksums);
    checksums[name] = checksumOf(part);
  }
  return checksums;
}

}  // namespace

void addChecksums(ordered_json& report) {
  auto checksums = checksumsOf(report);
  report[kPart][kChecksums] = std::move(checksums);
}

std::optional<std::string> alteredMember(const ordered_json& report) {
  const ordered_json& expected = report.at(kPart).at(kChecksums);
  const ordered_json found = checksumsOf(report);
  for (const auto& [name, checksum] : expected.items()) {
    if (!found.contains(name) || found[name] != checksum) return name;
  }
  for (const auto& [name, checksum] : found.items()) {
    if (!expected.contains(name)) return name;
  }
  return std::nullopt;
}

}  // namespace t4d::tools
