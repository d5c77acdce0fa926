#pragma once

#include <string>
#include <vector>

#include "conformance/corpus/corpus.h"
#include "conformance/driver/case_choice.h"
#include "conformance/driver/damage.h"
#include "t4d/error.h"

/// The cases for a reader under test: the files of the corpus, and damaged copies of the valid
/// ones.
namespace t4d::conformance {

/// One request to the reader.
struct Trial {
  std::string about;                 ///< "slice 0.5", "cut to 24 bytes"
  std::vector<std::string> request;  ///< {"describe"} or {"slice", "0.5"}
  /// Why it is wrong to accept or to refuse the file; empty if it is allowed. Completes a sentence
  /// that begins "accepted, but " or "refused, but ".
  std::string wrongToAccept;
  std::string wrongToRefuse;
  Answer answer;  ///< the required output if it accepts; empty if that does not matter
  Damage damage;  ///< to the file of the corpus
};

struct ReaderCase {
  std::string id;  ///< the id of the corpus file, or "cut/NAME", "flip/NAME", "overwrite/NAME"
  const CorpusFile* file = nullptr;
  std::vector<Trial> trials;
  std::string skipped;  ///< why the case is skipped; empty if it is not
};

/// The one feature that is not a feature of files: slices by x, y, z and other hyperplanes.
inline constexpr const char* kHyperplanes = "hyperplanes";

/// Everything that a reader may lack: kHyperplanes, and the features of files.
std::vector<std::string> whatAReaderMayLack();

struct CaseOptions {
  /// Features of HEAD that the reader does not support, so that it must refuse files that name one;
  /// also kHyperplanes, if it slices only at times.
  std::vector<std::string> without = {};
  /// Send ten times as many requests: about 30,000.
  bool thorough = false;
  /// Keep some 170 requests, for a reader that is slow to start: the smallest invalid file of
  /// each rule, valid files that together use every feature, and a few files damaged in each way.
  bool quick = false;
};

/// All cases, in the order in which the author of a reader should look at them: valid files, those
/// with the fewest features first; files left to the reader; invalid files; damage. They point into
/// `files`.
std::vector<ReaderCase> readerCases(const std::vector<CorpusFile>& files,
                                    const CaseOptions& options = {});

/// The corpus's damaged.json: the damaged files that readerCases makes without options, for test
/// runs without t4d.
std::string damagedText(const std::vector<CorpusFile>& files);

}  // namespace t4d::conformance
