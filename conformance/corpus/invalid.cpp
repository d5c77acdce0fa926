#include "conformance/corpus/cases.h"
#include "conformance/corpus/shapes.h"

namespace t4d::conformance {

std::vector<CorpusFile> invalidFiles() {
  Image image = Image::of({{"simplex", simplex()}});
  image.flip("file/checksum");
  CorpusFile file;
  file.id = "invalid/H2-header-checksum";
  file.verdict = Verdict::Invalid;
  file.features = {"index"};
  file.rule = "H2";
  file.fault = "The checksum of the file header is wrong.";
  file.offset = image.offset("file/checksum");
  file.bytes = image.bytes();
  return {file};
}

}  // namespace t4d::conformance
