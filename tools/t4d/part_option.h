#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "t4d/mesh.h"
#include "tools/t4d/input_identity.h"

namespace t4d::tools {

/// The option of every verb whose work can be divided among processes: `--part K/N`, and
/// `--most-parts`, which tells how large N can be.
class PartOption {
 public:
  /// `help` says what only a part of is done.
  void addTo(CLI::App& command, const std::string& help);

  /// The part; the whole unless --part is given.
  model::Part chosen() const { return part_.value_or(model::Part()); }
  bool isGiven() const { return part_.has_value(); }
  /// Whether either option is given.
  bool isAsked() const { return part_ || most_; }

  /// If --most-parts is given, prints `most` and returns the exit code. If --part asks for more
  /// parts than `most`, the number of `things` (such as "steps"), prints that and returns the exit
  /// code.
  std::optional<int> settle(std::uint64_t most, std::string_view things) const;

  /// The report on a part, with the member `part`, for `t4d join`: which part it is of which run,
  /// and checksums of what the report holds. `input` says what is equal for all runs with the same
  /// input, `state` what the report itself does not.
  nlohmann::ordered_json reportOf(nlohmann::ordered_json report, nlohmann::ordered_json input,
                                  nlohmann::ordered_json state = {}) const;

  /// The text of a report in JSON, which has that member if it is one of a part; `input` is asked
  /// for only then.
  std::string inReport(nlohmann::ordered_json report,
                       const std::function<nlohmann::ordered_json()>& input,
                       nlohmann::ordered_json state = {}) const;

 private:
  const CLI::App* command_ = nullptr;
  std::optional<model::Part> part_;
  bool most_ = false;
};

/// An option --part that says why the work of a verb cannot be divided.
void addNoPartOption(CLI::App& command, const std::string& why);

}  // namespace t4d::tools
