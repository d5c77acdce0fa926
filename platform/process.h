#pragma once

#include <cstdint>
#include <filesystem>

/// This process, and what the system knows of it.
namespace t4d::platform {

/// The program that runs; empty if it is not known.
std::filesystem::path executablePath();

/// Peak memory of this process so far, in bytes.
std::uint64_t peakBytes();
/// Peak memory of the largest process that this one has run and waited for.
std::uint64_t peakBytesOfChildren();

/// Without this, a program that crashes a hundred times would leave a hundred core dumps. Processes
/// that this one starts leave none, either.
void disableCoreDumps();

/// Prevents files that are opened from getting the number of a closed standard stream: messages
/// would be written to them. Writing to a closed stream stays an error.
void keepStandardStreams();
bool standardErrorIsTerminal();

}  // namespace t4d::platform
