# A plug-in links the static library if CMAKE_POSITION_INDEPENDENT_CODE says so, and a program loads
# it.
cmake_minimum_required(VERSION 3.25)
include(${settings})
start()
file(WRITE ${work_dir}/CMakeLists.txt "
cmake_minimum_required(VERSION 3.25)
project(plugin LANGUAGES CXX)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(T4D_COMPONENTS model)
add_subdirectory(${t4d_source} t4d)
add_library(plugin MODULE plugin.cpp)
target_link_libraries(plugin PRIVATE t4d::model)
add_executable(host host.cpp)
target_link_libraries(host PRIVATE \${CMAKE_DL_LIBS})
")
file(WRITE ${work_dir}/plugin.cpp [[
#include <t4d/motion.h>

extern "C" double heightAfter(double time) {
  const t4d::model::ScrewRun run{.duration = 4, .screw = {.translation = {0, 0, 8}}};
  const auto motion = t4d::model::chainScrews(0, {&run, 1});
  return motion ? motion->at(time).translation.z() : -1;
}
]])
file(WRITE ${work_dir}/host.cpp [[
#include <cstdio>
#include <dlfcn.h>

int main(int, char** arguments) {
  void* const plugin = dlopen(arguments[1], RTLD_NOW);
  if (!plugin) {
    std::puts(dlerror());
    return 1;
  }
  const auto heightAfter = reinterpret_cast<double (*)(double)>(dlsym(plugin, "heightAfter"));
  std::printf("%g\n", heightAfter(1));
}
]])
configure(${work_dir} -D CMAKE_BUILD_TYPE=)
run(${CMAKE_COMMAND} --build build)
run(build/host build/libplugin.so)
if(NOT run_output STREQUAL "2\n")
  message(FATAL_ERROR "the plug-in's motion is at '${run_output}' after a quarter of 8")
endif()
