#include "platform/isolated.h"

#include <exception>
#include <new>

namespace t4d::platform {

/// There is no fork here: the work runs in this process, without limits.
Result<IsolatedWork> runIsolated(const std::function<std::string()>& work,
                                 const WorkLimits& /*limits*/) {
  IsolatedWork done;
  try {
    done.result = work();
  } catch (const std::bad_alloc&) {
    done.end = IsolatedWork::End::OutOfMemory;
  } catch (...) {
    done.end = IsolatedWork::End::Crashed;
  }
  return done;
}

}  // namespace t4d::platform
