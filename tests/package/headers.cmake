# Compiles each public header alone and without a warning: one source file a header, with the
# include folders that the package gives and no others.
cmake_minimum_required(VERSION 3.25)
include(${settings})
start()
file(GLOB_RECURSE headers RELATIVE ${prefix}/include ${prefix}/include/*.h)
list(LENGTH headers count)
if(count GREATER 16)
  message(FATAL_ERROR "${count} headers are installed, 16 are the interface: ${headers}")
endif()
set(sources)
foreach(header IN LISTS headers)
  string(MAKE_C_IDENTIFIER ${header} name)
  file(WRITE ${work_dir}/project/${name}.cpp "#include <${header}>\n")
  list(APPEND sources ${name}.cpp)
endforeach()
list(JOIN sources " " sources)
file(WRITE ${work_dir}/project/CMakeLists.txt "
cmake_minimum_required(VERSION 3.25)
project(headers LANGUAGES CXX)
find_package(t4d REQUIRED)
set(targets \${t4d_INSTALLED_COMPONENTS})
list(TRANSFORM targets PREPEND t4d::)
add_library(headers STATIC ${sources})
# As if they were this project's own: system headers give no warnings.
set_target_properties(\${targets} PROPERTIES SYSTEM OFF)
target_link_libraries(headers PRIVATE \${targets})
")
set(flags "${flags} ${strict}")
# Nothing is run, so nothing needs to be optimised.
configure(project -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_BUILD_TYPE=)
run(${CMAKE_COMMAND} --build build)

# What is given to the library may be given by name, in part; and the library says its version.
string(REPLACE "." ", " numbers ${version})
file(WRITE ${work_dir}/named.cpp "#include <array>
#include <t4d/version.h>
#include <t4d/motion.h>
#include <t4d/mesh.h>
using namespace t4d::model;
ScrewRun run() { return {.duration = 4}; }
Segment segment() { return {.timeBegin = 1}; }
Motion motion() { return {.lengthUnit = \"mm\"}; }
KeyPose pose() { return {.time = 1}; }
Slab slab() { return {.timeEnd = 1}; }
static_assert(std::array{T4D_VERSION_MAJOR, T4D_VERSION_MINOR, T4D_VERSION_PATCH} == std::array{${numbers}});
")
separate_arguments(warnings UNIX_COMMAND "${strict}")
run(${compiler} -std=c++20 -fsyntax-only ${warnings} -I${prefix}/include -isystem
  ${prefix}/include/t4d/third_party -isystem /usr/include/eigen3 named.cpp)

# A Result that is ignored is a warning.
file(WRITE ${work_dir}/ignored.cpp "#include <t4d/error.h>
t4d::Result<void> work();
void ignore() { work(); }
")
execute_process(
  COMMAND ${compiler} -std=c++20 -fsyntax-only -I${prefix}/include -isystem
    ${prefix}/include/t4d/third_party ignored.cpp
  WORKING_DIRECTORY ${work_dir} ERROR_VARIABLE warning)
if(NOT warning MATCHES "nodiscard")
  message(FATAL_ERROR "an ignored Result gives no warning, but '${warning}'")
endif()
