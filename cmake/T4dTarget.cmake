# t4d_add_library(<folder> SOURCES ... HEADERS ... [PUBLIC ...] [PRIVATE ...])
#
# One static library a top-level folder, with the alias t4d::<folder>. Headers are included as
# "<folder>/<name>.h" from the project's root, and installed to be <t4d/<folder>/<name>.h>
# (cmake/install_headers.cmake).
function(t4d_add_library folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;HEADERS;PUBLIC;PRIVATE" ${ARGN})
  set(target t4d_${folder})
  add_library(${target} STATIC ${ARG_SOURCES})
  add_library(t4d::${folder} ALIAS ${target})
  target_sources(${target} PRIVATE ${ARG_HEADERS})
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${folder})
  t4d_own_code(${target})
  install(TARGETS ${target} EXPORT t4dTargets)
  install(CODE "
    set(folder ${folder})
    set(headers \"${ARG_HEADERS}\")
    set(source_dir \"${CMAKE_CURRENT_SOURCE_DIR}\")
    set(include_dir \"${CMAKE_INSTALL_INCLUDEDIR}\")")
  install(SCRIPT ${PROJECT_SOURCE_DIR}/cmake/install_headers.cmake)
endfunction()

# Flags for our own code. No contraction to fused multiply-add: results are the same bit for bit on
# every machine.
function(t4d_own_code target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Werror -ffp-contract=off)
  # From -O2 on g++ 12.2 drops the rounding of double(float(x)) where it makes vectors of straight
  # code: float32 files would promise bounds that their numbers do not keep.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -fno-tree-slp-vectorize)
  endif()
  # g++ 12 sees overflows in optimised inserts into std::string and std::vector where none are.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-restrict -Wno-stringop-overflow)
  endif()
endfunction()

# t4d_add_test(<name> SOURCES ... LINK ...): a GoogleTest program; each TEST is a test of ctest.
function(t4d_add_test name)
  if(NOT T4D_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gtest GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE
    T4D_SHARED_MESHES="${PROJECT_SOURCE_DIR}/../shared/meshes")
  t4d_own_code(${name})
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600)
endfunction()
