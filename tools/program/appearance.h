#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "t4d/convert/frame_slices.h"
#include "t4d/formats/t4d/metadata.h"
#include "t4d/formats/vertex_normals.h"
#include "t4d/model/times.h"

namespace t4d::tools {

/// How slices look: `--normals` and `--color`.
struct Appearance {
  std::string normals;
  std::string color;

  void addTo(CLI::App& command);

  std::optional<formats::NormalStyle> normalStyle() const;
  /// Colours of the bodies of a file that lasts for `span`; null if none are asked for. By body:
  /// the colour that the file says, or else one of a palette. By time: from dark blue at the
  /// beginning to yellow at the end.
  convert::BodyColor bodyColor(const formats::Metadata& metadata,
                               const model::TimeSpan& span) const;
};

}  // namespace t4d::tools
