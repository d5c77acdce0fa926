#pragma once

#include <string>

/// Hand-written files of the corpus, from conformance/corpus/files/.
namespace t4d::conformance {

extern const std::string kManifestSchema;
extern const std::string kAnswersSchema;
extern const std::string kDamagedSchema;
extern const std::string kLicense;
extern const std::string kReadme;
extern const std::string kChangelog;

}  // namespace t4d::conformance
