#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/measure/visit_fields.h"
#include "t4d/model/part.h"

namespace t4d::tools {

/// The fields that `envelope` writes: `--visits`, `--dwell`, `--first` and `--last`.
struct EnvelopeFields {
  std::array<std::string, 4> files;  ///< of each, in that order; "" for none

  void addTo(CLI::App& command);
  bool any() const;
};

struct WrittenField {
  std::string name;
  std::string file;
  std::uint64_t bytes;
};

/// What the fields of one run are made of.
struct FieldWork {
  measure::SpaceLattice lattice;  ///< of all parts
  model::Part part = {};
  /// What tells the parts of this run from others; empty for the whole fields.
  std::map<std::string, std::string> run = {};
  /// Puts the motion into a sink.
  std::function<Result<void>(model::Sink&)> put = {};
};

/// Fails if the fields of a part need more memory than that.
Result<void> checkFieldMemory(const measure::SpaceLattice& lattice, const model::Part& part,
                              double maxMemoryGiB);

/// Writes the fields that are asked for. Of a part, only its points are worked on.
Result<std::vector<WrittenField>> writeFields(const EnvelopeFields& fields, const FieldWork& work);

}  // namespace t4d::tools
