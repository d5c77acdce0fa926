#include "conformance/corpus/cases.h"

namespace t4d::conformance {

std::vector<AcceptedCase> implCases() { return {}; }

}  // namespace t4d::conformance
