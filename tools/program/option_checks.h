#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/model/error.h"
#include "t4d/model/part.h"
#include "t4d/verbs/output_check.h"

/// Validators for option values. A rejected value is a usage error; CLI11 puts the option's name
/// before the message.
namespace t4d::tools {

/// A finite number.
CLI::Validator finiteNumber();

/// A finite number above 0.
CLI::Validator numberAboveZero();
CLI::Validator numberFromZero();

/// An option of `least` to `most` finite numbers, with commas or spaces between them.
CLI::Option* addNumbers(CLI::App& command, const std::string& name, std::vector<double>& numbers,
                        const std::string& help, int least, int most, const std::string& form);

/// A number from 0 to less than 1.
CLI::Validator fractionBelowOne();

/// A whole number from `least` to `most` inclusive.
CLI::Validator wholeNumber(std::uint64_t least, std::uint64_t most);

/// Not 1.
CLI::Validator noLoneCopy();

/// `--part K/N`, part K of N: whole numbers, K from 1 to N.
void addPartOption(CLI::App& command, std::optional<model::Part>& part, const std::string& help);

/// A:B:N, see timesOf in numbers.h.
CLI::Validator evenTimesUpTo(std::uint64_t most);

/// A:B, two times, the first before the second.
CLI::Validator timeSpan();

/// A name that is not empty.
CLI::Validator someName();

/// A name for a .t4d file: any but those with the extension of a triangle mesh, .vdb or .json.
CLI::Validator noOtherFormat();

/// A file name that ends with .vdb.
CLI::Validator vdbFile();

/// A file name with the extension of a triangle mesh that can be written.
CLI::Validator writableTriangleMesh();

using verbs::misuseOfOutput;
using verbs::misuseOfOutputs;

/// Fails if one of these files cannot be written, so that it shows before the work and not after
/// it. Empty names are skipped.
Result<void> checkWritable(std::span<const std::string> outputs);

}  // namespace t4d::tools
