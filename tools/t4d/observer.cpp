#include "tools/t4d/observer.h"

namespace t4d::tools {

Observer& nobody() {
  static Observer observer;
  return observer;
}

}  // namespace t4d::tools
