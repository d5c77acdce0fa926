include(${CMAKE_CURRENT_LIST_DIR}/components.cmake)
macro(t4d_find)
  find_package(${ARGV} REQUIRED)
endmacro()
if(T4D_COMPONENTS STREQUAL "all")
  set(T4D_ENABLED_COMPONENTS ${t4d_ALL_COMPONENTS})
else()
  foreach(component IN LISTS T4D_COMPONENTS)
    if(NOT component IN_LIST t4d_ALL_COMPONENTS)
      message(FATAL_ERROR "T4D_COMPONENTS: there is no '${component}'; there are all, ${t4d_ALL_COMPONENTS}")
    endif()
  endforeach()
  t4d_with_needs(T4D_ENABLED_COMPONENTS ${T4D_COMPONENTS})
endif()
foreach(component IN LISTS T4D_ENABLED_COMPONENTS)
  t4d_find_packages(${component})
endforeach()
# Header-only libraries, which users of the installed package do not need: cmake/install.cmake
# installs a copy of tl/expected.hpp.
find_package(tl-expected REQUIRED)
find_package(fmt REQUIRED)
if(T4D_BUILD_TESTS OR "file" IN_LIST T4D_ENABLED_COMPONENTS OR "arrays" IN_LIST T4D_ENABLED_COMPONENTS)
  find_package(nlohmann_json REQUIRED)
endif()

# The public interface: all of it comes with t4d::model, whichever components are built.
file(GLOB T4D_PUBLIC_HEADERS CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/t4d/*.h)

# t4d_add_library(<folder> SOURCES ... [PUBLIC ...] [PRIVATE ...] [BUILD_ONLY ...]
#                 [PRECOMPILED <set>] [EACH_ALONE])
#
# One library per folder, with the alias t4d::<folder>; static, or with BUILD_SHARED_LIBS
# shared, of which every minor version has its own name. Its own headers, included as
# "<folder>/<name>.h", are not installed. BUILD_ONLY are header-only
# libraries that users of the installed package do not need. With EACH_ALONE the sources are not
# compiled together.
function(t4d_add_library folder)
  cmake_parse_arguments(ARG "EACH_ALONE" "PRECOMPILED" "SOURCES;PUBLIC;PRIVATE;BUILD_ONLY" ${ARGN})
  set(target t4d_${folder})
  add_library(${target} ${ARG_SOURCES})
  add_library(t4d::${folder} ALIAS ${target})
  set(needs ${t4d_${folder}_NEEDS})
  list(TRANSFORM needs PREPEND t4d::)
  if(folder STREQUAL "model")
    target_sources(${target} PUBLIC FILE_SET HEADERS
      BASE_DIRS ${PROJECT_SOURCE_DIR}/include FILES ${T4D_PUBLIC_HEADERS})
  endif()
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${target} PUBLIC ${needs} ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  foreach(library IN LISTS ARG_BUILD_ONLY)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:${library}>)
  endforeach()
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${folder}
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  if(BUILD_SHARED_LIBS)
    # Side by side, so that they and the programs find them wherever they are installed.
    set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}
      INSTALL_RPATH "$ORIGIN")
  endif()
  # The Python module and the program's t4d_openvdb are shared libraries. What shares its
  # precompiled headers with the programs is not part of them: see t4d_precompile.
  if(NOT ARG_PRECOMPILED STREQUAL "tools")
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE "${T4D_POSITION_INDEPENDENT}")
  endif()
  t4d_own_code(${target})
  t4d_instrument(${target})
  if(ARG_PRECOMPILED)
    t4d_precompile(${target} ${ARG_PRECOMPILED})
  endif()
  if(NOT ARG_EACH_ALONE)
    t4d_compile_together(${target})
  endif()
  if(T4D_INSTALL)
    install(TARGETS ${target} EXPORT t4d-${folder} FILE_SET HEADERS)
    install(EXPORT t4d-${folder} NAMESPACE t4d:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/t4d)
  endif()
endfunction()

# For what the fuzzers explore: the library, but not its tests.
function(t4d_instrument target)
  if(T4D_BUILD_FUZZERS)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
endfunction()

# Flags for our own code. Contraction to fused multiply-add is off, so that results are bit-identical
# on every machine, as far as sines and cosines of its C library are.
function(t4d_own_code target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -ffp-contract=off)
  # From -O2 on, g++ 12.2 drops the rounding of double(float(x)) where it vectorises straight-line
  # code: the numbers in float32 files would then exceed the bounds that the files state.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -fno-tree-slp-vectorize)
    # Where there is memory for it, g++ collects garbage less often: 9 % less time for 0.4 GB more.
    if(T4D_MEMORY_EACH GREATER 3000)
      target_compile_options(${target} PRIVATE "SHELL:--param ggc-min-heapsize=1000000")
    endif()
  endif()
  # g++ 12 warns of non-existent overflows in optimised inserts into std::string and std::vector.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-restrict -Wno-stringop-overflow -Wno-array-bounds -Wno-stringop-overread)
  endif()
endfunction()

# The first of these targets of ours that is not built (T4D_COMPONENTS), without t4d::; or nothing.
function(t4d_missing_component variable)
  foreach(component IN LISTS t4d_ALL_COMPONENTS)
    if("t4d::${component}" IN_LIST ARGN AND NOT component IN_LIST T4D_ENABLED_COMPONENTS)
      set(${variable} ${component} PARENT_SCOPE)
      return()
    endif()
  endforeach()
  set(${variable} "" PARENT_SCOPE)
endfunction()

# t4d_add_program(<name> SOURCES ... LINK ... [OPTIMISED]): a program, at the top of the build
# folder. OPTIMISED is for programs that contain hot code themselves.
function(t4d_add_program name)
  cmake_parse_arguments(ARG "OPTIMISED" "" "SOURCES;LINK" ${ARGN})
  t4d_missing_component(missing ${ARG_LINK})
  if(missing)
    message(STATUS "${name} is left out: it needs t4d::${missing}")
    return()
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
  target_link_libraries(${name} PRIVATE ${ARG_LINK} fmt::fmt)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
  t4d_own_code(${name})
  if(NOT ARG_OPTIMISED)
    t4d_compile_quickly(${name})
    t4d_precompile(${name} tools)
  endif()
endfunction()

# Build all tests, or those that read files: targets of the presets asan and asan-readers.
if(T4D_BUILD_TESTS)
  add_custom_target(all_tests)
  add_custom_target(reader_tests)
endif()

# t4d_add_test(<name> SOURCES ... LINK ... [PRECOMPILED <set>] [READS_FILES]): a GoogleTest program;
# each TEST is one ctest test. READS_FILES: it gives the library files, or bytes of them, to read.
function(t4d_add_test name)
  if(NOT T4D_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "READS_FILES" "PRECOMPILED" "SOURCES;LINK" ${ARGN})
  t4d_missing_component(missing ${ARG_LINK})
  if(missing)
    message(STATUS "${name} is left out: it needs t4d::${missing}")
    return()
  endif()
  add_executable(${name} ${ARG_SOURCES})
  add_dependencies(all_tests ${name})
  if(ARG_READS_FILES)
    add_dependencies(reader_tests ${name})
  endif()
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
  target_link_libraries(${name} PRIVATE ${ARG_LINK} fmt::fmt GTest::gtest GTest::gmock GTest::gtest_main)
  t4d_own_code(${name})
  t4d_compile_quickly(${name})
  # Tests of different things name their helpers alike.
  set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 8)
  if(NOT ARG_PRECOMPILED)
    set(ARG_PRECOMPILED tests)
  endif()
  t4d_precompile(${name} ${ARG_PRECOMPILED})
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600)
endfunction()
