# Precompiled headers. Most of the time that t4d takes to compile goes into headers of others, so they
# are parsed once for all that share a set of flags. -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON builds
# each source alone and without.
set(T4D_PRECOMPILED_library
  <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <optional>
  <span> <string> <string_view> <unordered_map> <utility> <vector>
  <Eigen/Geometry> <fmt/format.h> <tl/expected.hpp>)
set(T4D_PRECOMPILED_tools ${T4D_PRECOMPILED_library} <CLI/CLI.hpp> <nlohmann/json.hpp>)
set(T4D_PRECOMPILED_tests ${T4D_PRECOMPILED_library} <fstream> <sstream>
  <gmock/gmock.h> <gtest/gtest.h> <nlohmann/json.hpp>)
set(T4D_PRECOMPILED_openvdb ${T4D_PRECOMPILED_library} <openvdb/openvdb.h>)
set(T4D_PRECOMPILED_openvdb_tests ${T4D_PRECOMPILED_tests} <openvdb/openvdb.h>)

# t4d_precompile(<target> <set>): the headers of a set above, shared with the other targets that have
# it.
function(t4d_precompile target set)
  if(set MATCHES "openvdb")  # has one target
    target_precompile_headers(${target} PRIVATE ${T4D_PRECOMPILED_${set}})
    return()
  endif()
  set(owner t4d_precompiled_${set})
  if(NOT TARGET ${owner})
    add_library(${owner} OBJECT ${PROJECT_SOURCE_DIR}/cmake/empty.cpp)
    target_link_libraries(${owner} PRIVATE Eigen3::Eigen tl::expected fmt::fmt)
    if(set STREQUAL "tests")
      target_link_libraries(${owner} PRIVATE GTest::gtest GTest::gmock)
    endif()
    t4d_own_code(${owner})
    if(NOT set STREQUAL "library")
      t4d_compile_quickly(${owner})
    endif()
    target_precompile_headers(${owner} PRIVATE ${T4D_PRECOMPILED_${set}})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
endfunction()

# For code in which no time is spent: little optimisation, and several sources compiled as one, so that
# the inline functions of CLI11, nlohmann/json and GoogleTest are compiled once for all of them. Each
# took half of the build. Names in anonymous namespaces must differ within a target.
function(t4d_compile_quickly target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON)
  endif()
endfunction()
