#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "t4d/formats/input_file.h"

/// The text of USD (.usda) as a tree. Values stay text until someone asks for their numbers: of
/// samples that are read one after the other, one or two are numbers at a time.
namespace t4d::formats {

/// A file, and its text: all of it, or that of the first file of a package. Views of the tree refer
/// to it.
struct UsdDocument {
  std::shared_ptr<const InputFile> file = {};
  std::string_view text = {};

  /// `path:LINE` of a part of the text.
  Place where(std::string_view part) const;
};

struct UsdField {
  std::string_view key = {};
  std::string_view value = {};
};

struct UsdSample {
  double timeCode = 0;
  std::string_view value = {};
};

struct UsdProperty {
  std::string_view type = {};  ///< "rel" of a relationship
  std::string_view name = {};
  std::optional<std::string_view> value = {};
  std::vector<UsdSample> samples = {};  ///< in the order of their times
  bool isSpline = false;
};

struct UsdPrim {
  std::string_view specifier = {};  ///< def, over or class
  std::string_view type = {};
  std::string_view name = {};
  std::vector<UsdField> metadata = {};
  std::vector<UsdProperty> properties = {};
  std::vector<UsdPrim> children = {};
  std::string_view variantSet = {};  ///< the first, if there is one

  const UsdProperty* property(std::string_view wanted) const;
  std::optional<std::string_view> field(std::string_view wanted) const;
};

struct UsdLayer {
  std::vector<UsdField> metadata = {};
  std::vector<UsdPrim> prims = {};

  std::optional<std::string_view> field(std::string_view wanted) const;
};

/// Finds the text. Fails on binary files (.usdc, also in a package), which other programs convert.
Result<UsdDocument> openUsd(InputFile file);

/// Reads the tree of a document, which must outlive it.
Result<UsdLayer> readUsdLayer(const UsdDocument& document);

/// How a value is given: a single one, or an array of them in brackets.
enum class UsdShapeOf : unsigned char { One, Array };

/// The numbers of a value of `width` numbers each, nested in parentheses in any way. Of a type that
/// is not of doubles they are rounded to float32, as USD does. Fails on what is not of that form.
Result<std::vector<double>> usdNumbers(const UsdDocument& document, std::string_view value,
                                       std::size_t width, UsdShapeOf shape, std::string_view type);

/// The text of a string or token, without quotes; of anything else, the value as it is.
std::string usdUnquoted(std::string_view value);
/// The tokens of an array of them.
Result<std::vector<std::string>> usdTokens(const UsdDocument& document, std::string_view value);

}  // namespace t4d::formats
