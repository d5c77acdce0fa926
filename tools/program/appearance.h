#pragma once

#include <optional>
#include <span>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "t4d/convert/attribute_colors.h"
#include "t4d/convert/frame_slices.h"
#include "t4d/formats/t4d/metadata.h"
#include "t4d/formats/triangle/vertex_normals.h"
#include "t4d/model/times.h"

namespace t4d::tools {

/// What gives slices their colours.
struct Painting {
  convert::Paint paint;                               ///< null if no colours are asked for
  std::optional<convert::AttributeColors> attribute;  ///< if they are those of one

  /// A line that says the range of the attribute; "" if there is none.
  std::string text() const;
  /// The range as [low, high]; null if there is none.
  nlohmann::json range() const;
};

/// Colours by the attribute `velocity`, from a speed of 0 to the largest.
Painting speedPainting(double largest);

/// How slices look: `--normals` and `--color`.
struct Appearance {
  std::string normals;
  std::string color;

  void addTo(CLI::App& command);

  /// The colours are those of the velocity of slices (speedPainting).
  bool isBySpeed() const { return color == "speed"; }

  std::optional<formats::NormalStyle> normalStyle() const;
  /// Colours of the bodies of a file that lasts for `span`. By body: the colour that the file says,
  /// or else one of a palette. By time: from dark blue at the beginning to yellow at the end. By an
  /// attribute: convert::AttributeColors, whose range is that of all bodies or meshes. Not by
  /// speed.
  Result<Painting> painting(const formats::Metadata& metadata, const model::TimeSpan& span,
                            std::span<const model::Body> bodies) const;
  Result<Painting> painting(const formats::Metadata& metadata, const model::TimeSpan& span,
                            std::span<const formats::NamedMesh> meshes) const;

 private:
  template <class Element>
  Result<Painting> paintingOf(const formats::Metadata& metadata, const model::TimeSpan& span,
                              std::span<const Element> elements) const;
};

}  // namespace t4d::tools
