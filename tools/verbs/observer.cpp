#include "tools/verbs/observer.h"

namespace t4d::verbs {

Observer& nobody() {
  static Observer observer;
  return observer;
}

}  // namespace t4d::verbs
