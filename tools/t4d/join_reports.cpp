#include "tools/t4d/join_reports.h"

#include <algorithm>
#include <map>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/input_file.h"
#include "formats/text/json_check.h"
#include "tools/t4d/collide.h"
#include "tools/t4d/compress.h"
#include "tools/t4d/frames.h"
#include "tools/t4d/measure.h"
#include "tools/t4d/members.h"
#include "tools/t4d/part_report.h"
#include "tools/t4d/quality_parts.h"
#include "tools/t4d/track_parts.h"
#include "tools/t4d/validate_parts.h"
#include "tools/t4d/voxelize.h"
#include "tools/t4d/weave.h"

namespace t4d::tools {
namespace {

using nlohmann::ordered_json;

/// The rules by which the reports of a verb are joined, as their members have them.
JoinRules rulesOfVerb(const std::string& verb) {
  static const std::map<std::string, JoinRules (*)(), std::less<>> kVerbs = {
      {"collide", rulesOf<CollideReport>},
      {"compress", rulesOf<CompressReport>},
      {"frames", rulesOf<FramesReport>},
      {"measure", rulesOf<MeasureReport>},
      {"rasterize", rulesOf<VoxelSeriesReport>},
      {"voxelize", rulesOf<VoxelizeReport>},
      {"weave", rulesOf<WeaveReport>}};
  const auto found = kVerbs.find(verb);
  return found == kVerbs.end() ? JoinRules() : found->second();
}

struct Report {
  std::filesystem::path file;
  ordered_json json;

  const ordered_json& part() const { return json.at("part"); }
  std::uint64_t number() const { return part().at("number"); }
};

Result<Report> readReport(const std::filesystem::path& path) {
  const auto file = formats::readInputFile(path);
  if (!file) return file.error();
  if (auto sound = formats::checkJson(file->bytes, path.string()); !sound) return sound.error();
  Report report{path, ordered_json::parse(file->bytes, nullptr, false)};
  if (report.json.is_discarded()) return invalid("is not JSON", path.string());
  try {
    const ordered_json& part = report.json.at("part");
    for (const char* name : {"verb", "version"}) part.at(name).get<std::string>();
    for (const char* name : {"number", "count"}) part.at(name).get<std::uint64_t>();
    part.at("options").items();
    part.at("checksums").items();
    return report;
  } catch (const ordered_json::exception&) {
    return invalid("is not the report of a part", path.string(), Remedy::PartReports);
  }
}

/// How the run of a part differs from that of the first one; "" if it does not.
std::string differenceOf(const Report& first, const Report& other) {
  const ordered_json& a = first.part();
  const ordered_json& b = other.part();
  for (const char* name : {"verb", "version", "count"}) {
    if (a.at(name) != b.at(name)) {
      return fmt::format("its {} is {}, and that of {} is {}",
                         std::string_view(name) == "count" ? "number of parts" : name,
                         b.at(name).dump(), first.file.string(), a.at(name).dump());
    }
  }
  const auto ofOptions = [&](const ordered_json& left, const ordered_json& right) -> std::string {
    for (const auto& [name, value] : left.items()) {
      if (right.contains(name) && right[name] == value) continue;
      return fmt::format("{} is {}, and for {} {}", name,
                         right.contains(name) ? right[name].dump() : "not given",
                         first.file.string(), value.dump());
    }
    return {};
  };
  if (auto text = ofOptions(a.at("options"), b.at("options")); !text.empty()) return text;
  for (const auto& [name, value] : b.at("options").items()) {
    if (a.at("options").contains(name)) continue;
    return fmt::format("{} is {}, and not given for {}", name, value.dump(), first.file.string());
  }
  if (a.contains("input") && b.contains("input")) {
    if (auto text = ofOptions(a.at("input"), b.at("input")); !text.empty()) {
      return "of the input, " + text;
    }
  }
  return {};
}

/// Sorts the reports by their numbers; fails unless they are all parts of one run.
Result<void> putInOrder(std::vector<Report>& reports) {
  for (const Report& report : reports) {
    const std::string difference = differenceOf(reports.front(), report);
    if (difference.empty()) continue;
    return invalid("is of another run: " + difference, report.file.string());
  }
  std::ranges::stable_sort(reports, {}, &Report::number);
  const std::uint64_t count = reports.front().part().at("count");
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const std::uint64_t number = reports[i].number();
    if (number == i + 1) continue;
    const bool twice = i > 0 && number == reports[i - 1].number();
    return invalid(twice ? fmt::format("part {} of {} is given twice, also as {}", number, count,
                                       reports[i - 1].file.string())
                         : fmt::format("part {} of {} is missing", i + 1, count),
                   reports[i].file.string());
  }
  if (reports.size() == count) return {};
  return invalid(fmt::format("part {} of {} is missing", reports.size() + 1, count),
                 reports.back().file.string());
}

/// Fails for a report that is not as the verb wrote it.
Result<void> checkWhole(const Report& report) {
  const auto altered = alteredMember(report.json);
  if (!altered) return {};
  return invalid(fmt::format("'{}' is not what {} wrote, by its checksum; make the report again",
                             *altered, report.part().at("verb").get<std::string>()),
                 report.file.string());
}

ordered_json added(const ordered_json& a, const ordered_json& b) {
  if (a.is_null() || b.is_null()) return {};
  if (a.is_array()) {
    ordered_json sum = a;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = added(a[i], b.at(i));
    return sum;
  }
  if (a.is_number_float() || b.is_number_float()) return a.get<double>() + b.get<double>();
  return a.get<std::uint64_t>() + b.get<std::uint64_t>();
}

ordered_json both(Joined rule, ordered_json a, const ordered_json& b) {
  switch (rule) {
    case Joined::Added:
      return added(a, b);
    case Joined::Most:
      return a.is_null() || (b.is_number() && b.get<double>() > a.get<double>()) ? b : a;
    case Joined::First:
      return a;
    case Joined::Last:
      return b;
    case Joined::All:
      return a.get<bool>() && b.get<bool>();
    case Joined::Appended:
      for (const ordered_json& item : b) a.push_back(item);
      return a;
    case Joined::Unknown:
      break;
  }
  return {};
}

/// Throws nlohmann::json::exception for what is no report of the verb.
ordered_json joinedByRules(const std::vector<ordered_json>& reports, const JoinRules& rules) {
  ordered_json all = reports.front();
  all.erase("part");
  for (const auto& [name, value] : all.items()) {
    const Joined rule = rules.at(name);
    if (rule == Joined::Unknown && reports.size() > 1) value = nullptr;
    for (std::size_t i = 1; i < reports.size(); ++i) value = both(rule, value, reports[i].at(name));
  }
  // Each verb lists as many.
  constexpr std::size_t kMostListed = 1000;
  if (all.contains("parts_lost") && all["parts_lost"].size() > kMostListed) {
    all["parts_lost"].erase(all["parts_lost"].begin() + kMostListed, all["parts_lost"].end());
  }
  return all;
}

Result<JoinedReport> joinedValidations(const std::vector<ordered_json>& reports) {
  std::vector<PartValidation> parts;
  for (const ordered_json& report : reports) {
    auto part = partValidationOf(report.at("part").at("state"));
    if (!part) throw ordered_json::other_error::create(600, "no state of a part", &report);
    parts.push_back(std::move(*part));
  }
  auto validation = joinedValidation(parts);
  if (!validation) return validation.error();
  validation->deep = reports.front().at("part").at("options").contains("--deep");
  return JoinedReport{"validate", reportText(*validation), validation->valid()};
}

Result<JoinedReport> joined(const std::string& verb, const std::vector<ordered_json>& reports) {
  if (verb == "validate") return joinedValidations(reports);
  if (verb == "quality") {
    const std::uint64_t worst = reports.front().at("part").at("input").at("worst");
    return JoinedReport{verb, jsonText(joinedQuality(reports, worst))};
  }
  if (verb == "track") {
    const auto tracks = joinedTracking(reports);
    if (!tracks) return tracks.error();
    return JoinedReport{verb, reportText(*tracks)};
  }
  if (const JoinRules rules = rulesOfVerb(verb); !rules.empty()) {
    return JoinedReport{verb, jsonText(joinedByRules(reports, rules))};
  }
  return invalid(fmt::format("is of the verb {}, whose files are joined, not its reports", verb));
}

}  // namespace

Result<JoinedReport> joinReports(const std::vector<std::filesystem::path>& files) {
  std::vector<Report> reports;
  for (const auto& file : files) {
    auto report = readReport(file);
    if (!report) return report.error();
    reports.push_back(std::move(*report));
  }
  if (reports.empty()) return invalid("no report is to be joined");
  if (auto good = putInOrder(reports); !good) return good.error();
  for (const Report& report : reports) {
    if (auto whole = checkWhole(report); !whole) return whole.error();
  }
  std::vector<ordered_json> values;
  for (Report& report : reports) values.push_back(std::move(report.json));
  const std::string verb = values.front().at("part").at("verb");
  const std::string where = reports.front().file.string();
  try {
    auto all = joined(verb, values);
    if (!all && all.error().where.empty()) all.error().where = where;
    return all;
  } catch (const std::exception&) {
    return invalid(fmt::format("or another of these is not a whole report of {} on a part", verb),
                   where);
  }
}

}  // namespace t4d::tools
