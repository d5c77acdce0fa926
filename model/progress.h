#pragma once

#include "t4d/mesh.h"

namespace t4d::model {

/// The progress of a part of a job, from one fraction of it to another.
inline Progress partOf(const Progress& progress, double from, double to) {
  if (!progress) return {};
  return [progress, from, to](double fraction) { progress(from + fraction * (to - from)); };
}

/// That of one of `count` things that follow one another.
inline Progress eachOf(const Progress& progress, std::uint64_t number, std::uint64_t count) {
  const auto all = static_cast<double>(count);
  return partOf(progress, static_cast<double>(number) / all, static_cast<double>(number + 1) / all);
}

}  // namespace t4d::model
