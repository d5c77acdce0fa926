#pragma once

#include <new>
#include <string>
#include <type_traits>

#include "t4d/error.h"

namespace t4d::formats {

/// Returns the result of `function`, or an error if memory runs out: a valid file may hold more
/// than fits into memory.
template <class Function>
std::invoke_result_t<Function> withinMemory(const std::string& where, Function&& function) {
  try {
    return function();
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::Failed, "what it holds does not fit into memory", where);
  }
}

}  // namespace t4d::formats
