#include "conformance/corpus/cases.h"

namespace t4d::conformance {

std::vector<CorpusFile> implFiles() { return {}; }

}  // namespace t4d::conformance
