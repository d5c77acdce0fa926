#pragma once

#include <functional>
#include <string>
#include <vector>

#include "t4d/conformance/corpus/corpus.h"
#include "t4d/model/error.h"

/// What a reader under test is put to: the files of the corpus as they are, and damage to the valid
/// ones of them.
namespace t4d::conformance {

/// One start of the reader.
struct Trial {
  std::string about;                 ///< "slice 0.5", "cut to 24 bytes"
  std::vector<std::string> request;  ///< {"describe"} or {"slice", "0.5"}
  /// Why it is wrong to accept or to refuse the file; empty where a reader may. They go on from
  /// "accepted, but " and "refused, but ".
  std::string wrongToAccept;
  std::string wrongToRefuse;
  Answer answer;  ///< what it must print if it accepts; no text where that does not matter
  /// The file that it is given, from that of the corpus; none where it is that one.
  std::function<std::string(const std::string&)> damage;
};

struct ReaderCase {
  std::string id;  ///< that of the corpus file, or "cut/NAME", "flip/NAME", "overwrite/NAME"
  const CorpusFile* file = nullptr;
  std::vector<Trial> trials;
  std::string skipped;  ///< why it is not to be run; mostly empty
};

struct CaseOptions {
  /// Features of HEAD that the reader does not know: it must refuse a file that names one of them.
  std::vector<std::string> without;
  /// Ten times as many starts: some 30,000.
  bool thorough = false;
};

/// All cases, in the order in which somebody who writes a reader will want to look at them: valid
/// files, those with the fewest features first, what readers may decide, invalid files, damage.
/// They point to `files`.
std::vector<ReaderCase> readerCases(const std::vector<CorpusFile>& files,
                                    const CaseOptions& options = {});

/// Keeps the cases that match one of `only`, where there are any, and marks those that match one of
/// `skip`. A pattern is a glob of the id ("invalid/H*", where * matches / too) or of the name in it
/// ("one-simplex"), or a folder ("cut"). Errors: a pattern that matches nothing; no case is left.
Result<void> selectCases(std::vector<ReaderCase>& cases, const std::vector<std::string>& only,
                         const std::vector<std::string>& skip);

}  // namespace t4d::conformance
