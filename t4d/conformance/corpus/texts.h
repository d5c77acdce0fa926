#pragma once

#include <string>

/// Files of the corpus that are written by hand: t4d/conformance/corpus/files/ has them.
namespace t4d::conformance {

extern const std::string kManifestSchema;
extern const std::string kReadme;

}  // namespace t4d::conformance
