#pragma once

#include <string_view>

#include "t4d/mesh.h"

namespace t4d::model {

inline constexpr std::string_view kStopped = "stopped";

/// Whether this is the error of work that its caller has told to stop.
inline bool isStop(const Error& error) {
  return error.code == ErrorCode::Failed && error.message == kStopped;
}

/// Fails if the caller tells the work to stop.
inline Result<void> report(const Progress& progress, double fraction) {
  if (!progress || progress(fraction)) return {};
  return fail(ErrorCode::Failed, std::string(kStopped));
}

/// Reports that `done` of `count` things are done.
inline Result<void> report(const Progress& progress, std::uint64_t done, std::uint64_t count) {
  return report(progress, static_cast<double>(done) / static_cast<double>(count));
}

/// The progress of a part of a job, from one fraction of it to another.
inline Progress partOf(const Progress& progress, double from, double to) {
  if (!progress) return {};
  return [progress, from, to](double fraction) { return progress(from + fraction * (to - from)); };
}

/// The progress of step `number` out of `count` equal steps.
inline Progress eachOf(const Progress& progress, std::uint64_t number, std::uint64_t count) {
  const auto all = static_cast<double>(count);
  return partOf(progress, static_cast<double>(number) / all, static_cast<double>(number + 1) / all);
}

}  // namespace t4d::model
