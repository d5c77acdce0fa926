#include "tools/bench/report.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace t4d::bench {
namespace {

double secondsOf(const std::function<void()>& run) {
  const auto begin = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

double medianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

std::optional<double> Row::noise() const {
  if (ratios.empty()) return std::nullopt;
  std::vector<double> deviations;
  for (const double each : ratios) deviations.push_back(std::abs(each / ratio() - 1));
  return medianOf(std::move(deviations));
}

Row rowOfPairs(std::string what, const std::vector<double>& seconds, std::string against,
               const std::vector<double>& againstSeconds) {
  Row row{std::move(what), medianOf(seconds), std::move(against), medianOf(againstSeconds)};
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    row.ratios.push_back(seconds[i] / againstSeconds[i]);
  }
  return row;
}

Row compare(int repetitions, std::string what, const std::function<void()>& run,
            std::string against, const std::function<void()>& runAgainst) {
  std::vector<double> seconds;
  std::vector<double> againstSeconds;
  for (int i = 0; i < repetitions; ++i) {
    seconds.push_back(secondsOf(run));
    againstSeconds.push_back(secondsOf(runAgainst));
  }
  return rowOfPairs(std::move(what), seconds, std::move(against), againstSeconds);
}

double medianSeconds(int repetitions, const std::function<void()>& run) {
  std::vector<double> seconds(static_cast<std::size_t>(repetitions));
  for (double& each : seconds) each = secondsOf(run);
  return medianOf(seconds);
}

std::string textOf(const Report& report) {
  std::string text = fmt::format("{}\nmedians of {}\n\n", report.input, report.repetitions);
  text += fmt::format("{:<34} {:>9}   {:<34} {:>9} {:>9}   {}\n", "", "seconds", "against",
                      "seconds", "ratio", "noise");
  for (const Row& row : report.rows) {
    text += fmt::format("{:<34} {:>9.5f}   {:<34} {:>9.5f} {:>9.3g}", row.what, row.seconds,
                        row.against, row.againstSeconds, row.ratio());
    if (const auto noise = row.noise()) text += fmt::format("   {:.1f} %", 100 * *noise);
    text += "\n";
  }
  text += "\n";
  for (const Figure& figure : report.figures) {
    text += fmt::format("{:<48} {:>9.4g} {}\n", figure.what, figure.value, figure.unit);
  }
  return text;
}

std::string jsonOf(const Report& report) {
  nlohmann::ordered_json json = {{"input", report.input}, {"repetitions", report.repetitions}};
  for (const Row& row : report.rows) {
    json["rows"].push_back({{"what", row.what},
                            {"seconds", row.seconds},
                            {"against", row.against},
                            {"against_seconds", row.againstSeconds},
                            {"ratio", row.ratio()}});
    if (const auto noise = row.noise()) json["rows"].back()["noise"] = *noise;
  }
  for (const Figure& figure : report.figures) {
    json["figures"].push_back(
        {{"what", figure.what}, {"value", figure.value}, {"unit", figure.unit}});
  }
  return json.dump(2) + "\n";
}

}  // namespace t4d::bench
