# Precompiled headers. Most of t4d's compile time goes into third-party headers, so they are parsed
# once for all targets that share a set of flags. -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON compiles
# each source on its own, without them.
set(T4D_PRECOMPILED_library
  <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <optional>
  <span> <string> <string_view> <unordered_map> <utility> <vector>
  <Eigen/Geometry> <fmt/format.h> <tl/expected.hpp>)
# For targets whose code is rarely the bottleneck: at -O2, which compiles in two thirds of the time of
# -O3. The level has to be that of the precompiled headers: g++ takes it from them.
set(T4D_PRECOMPILED_library_o2 ${T4D_PRECOMPILED_library})
set(T4D_PRECOMPILED_tools ${T4D_PRECOMPILED_library} <CLI/CLI.hpp> <nlohmann/json.hpp>)
set(T4D_PRECOMPILED_tests ${T4D_PRECOMPILED_library} <fstream> <sstream>
  <gmock/gmock.h> <gtest/gtest.h> <nlohmann/json.hpp>)
set(T4D_PRECOMPILED_openvdb ${T4D_PRECOMPILED_library} <openvdb/openvdb.h>)
set(T4D_PRECOMPILED_openvdb_tests ${T4D_PRECOMPILED_tests} <openvdb/openvdb.h>)

# t4d_precompile(<target> <set>): precompiles the headers of a set above, shared with the other
# targets that use the set.
function(t4d_precompile target set)
  if(set MATCHES "openvdb")  # used by a single target
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
    t4d_optimise_as(${owner} ${set})
    t4d_position_as(${owner} ${set})
    if(set MATCHES "library")
      t4d_instrument(${owner})
    else()
      t4d_compile_quickly(${owner})
    endif()
    target_precompile_headers(${owner} PRIVATE ${T4D_PRECOMPILED_${set}})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
  t4d_optimise_as(${target} ${set})
  t4d_position_as(${target} ${set})
endfunction()

# The flags of a set of the library.
function(t4d_optimise_as target set)
  if(set STREQUAL "library_o2")
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O2>)
  endif()
endfunction()

# The same for all targets of a set: whether they may become part of a shared library.
function(t4d_position_as target set)
  if(set MATCHES "library")
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE "${T4D_POSITION_INDEPENDENT}")
  elseif(T4D_ALL_POSITION_INDEPENDENT)
    # Of programs, the property would ask for -fPIE.
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${target} PRIVATE -fPIC)
  endif()
endfunction()

# Compiles several sources of a target as one, so that the headers' inline functions and templates are
# compiled once for all of them; that halves the build. Names in anonymous namespaces must differ
# within a target. The more sources are one, the less is compiled twice: 24 take a third less
# processor time than three times 8, and 1.4 GB of memory. With many processors, 8 are done sooner.
cmake_host_system_information(RESULT T4D_PROCESSORS QUERY NUMBER_OF_LOGICAL_CORES)
cmake_host_system_information(RESULT T4D_MEMORY QUERY TOTAL_PHYSICAL_MEMORY)
math(EXPR T4D_MEMORY_EACH "${T4D_MEMORY} / ${T4D_PROCESSORS}")  # MiB for a processor
if(T4D_PROCESSORS GREATER 4)
  set(together 8)
else()
  set(together 24)
endif()
set(T4D_SOURCES_TOGETHER ${together} CACHE STRING
  "Sources that are compiled as one; few make it quicker to build after a change")
function(t4d_compile_together target)
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    set_target_properties(${target} PROPERTIES
      UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${T4D_SOURCES_TOGETHER})
  endif()
endfunction()

# For code that is never the bottleneck.
function(t4d_compile_quickly target)
  t4d_compile_together(${target})
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()
