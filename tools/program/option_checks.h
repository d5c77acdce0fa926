#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <CLI/CLI.hpp>

/// Checks of what options are given, made while the command line is read: what they refuse is wrong
/// usage, and CLI11 puts the option's name before what they say.
namespace t4d::tools {

/// A number that is finite.
CLI::Validator finiteNumber();

/// A finite number above 0.
CLI::Validator numberAboveZero();

/// A number from 0 to less than 1.
CLI::Validator fractionBelowOne();

/// A whole number, both bounds included.
CLI::Validator wholeNumber(std::uint64_t least, std::uint64_t most);

/// A name that is not empty.
CLI::Validator someName();

/// Why the file `output` must not be written where the others are read, by whatever name: it is one
/// of them, or lies in a folder of frames that is one of them.
std::optional<std::string> misuseOfOutput(const std::string& output,
                                          std::span<const std::string> inputs);

}  // namespace t4d::tools
