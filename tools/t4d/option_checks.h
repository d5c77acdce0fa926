#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "t4d/error.h"
#include "t4d/mesh.h"

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

/// A number other than 1.
CLI::Validator noLoneCopy();

/// `--part K/N`, part K of N: whole numbers, K from 1 to N.
void addPartOption(CLI::App& command, std::optional<model::Part>& part, const std::string& help);

/// A:B:N or T1,T2,..., see timesOf in numbers.h.
CLI::Validator timesUpTo(std::uint64_t most);

/// A:B, two times, the first before the second.
CLI::Validator timeSpan();

/// A name that is not empty.
CLI::Validator someName();

/// The name of an output file: one that ends with one of these extensions, in upper or lower case,
/// so that a mistyped name replaces no file of another kind. Devices and pipes, and `-` for the
/// standard output, have no extension.
CLI::Validator outputFile(std::vector<std::string_view> extensions);

CLI::Validator htmlFile();

/// A file name whose extension tells what is written.
CLI::Validator outputByExtension(std::vector<std::string_view> extensions);

/// A file name with the extension of a triangle mesh that can be written.
CLI::Validator writableTriangleMesh();

/// Fails if one of these files cannot be written, if two of them are one, or if one is an input,
/// so that it shows before the work and not after it. Empty names are skipped.
Result<void> checkOutputs(std::span<const std::string> outputs,
                          std::span<const std::string> inputs = {});

}  // namespace t4d::tools
