#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "t4d/conformance/answers.h"
#include "t4d/model/error.h"

/// Files for readers of .t4d to be tried on, made by our own code: valid ones with the answers that
/// a reader must give, files with one fault each, and files of which a reader may decide.
namespace t4d::conformance {

enum class Validity : std::uint8_t {
  Valid,    ///< a reader must accept it
  Invalid,  ///< a reader must refuse it
  Either,   ///< a reader may do one or the other; if it accepts, its answers must be right
};

/// "valid", "invalid", "either".
const char* nameOf(Validity validity);

/// What `slice TIME` must answer.
struct ExpectedSlice {
  double time = 0;
  std::string answer;  ///< JSON, as in Answer
  std::string within;
};

struct CorpusFile {
  std::string id;  ///< folder and name: "invalid/H2-header-checksum"
  Validity validity = Validity::Valid;
  /// What the file uses: "zstd", "means", "no-index", "float32", ... A reader's tests can be told
  /// to leave out what it does not do.
  std::vector<std::string> features;
  /// The number of the broken rule of SPEC.md; of what a reader may decide, the anchor of the
  /// section that leaves it open ("head"). Empty for valid files.
  std::string rule;
  std::string fault;  ///< one sentence: what the file shows, what is wrong, or what may be decided
  std::optional<std::uint64_t> offset;  ///< of the fault, in bytes
  std::string bytes;                    ///< the file
  std::optional<Answer> describe;       ///< where the file can be accepted
  std::vector<ExpectedSlice> slices;
};

inline constexpr const char* kCorpusVersion = "1.0.0";

/// All files, in order of their ids; always the same.
std::vector<CorpusFile> makeCorpus();

/// The corpus's manifest.json. `manifest.schema.json` says what is in it.
std::string manifestText(const std::vector<CorpusFile>& files);

/// The JSON beside a file that can be accepted: {"describe": {"answer", "within"}, "slices":
/// [...]}.
std::string expectedText(const CorpusFile& file);

/// Writes all files into `directory`, which is made where it is missing: ID.t4d and ID.json, the
/// manifest with its schema, and a README.
Result<void> writeCorpus(const std::filesystem::path& directory);

/// What is different between `directory` and what writeCorpus writes, a sentence each. Files of
/// more than 1 MiB may be missing: the project's sources are without them.
Result<std::vector<std::string>> verifyCorpus(const std::filesystem::path& directory);

}  // namespace t4d::conformance
