# With BUILD_SHARED_LIBS the library is shared, with the minor version in its name, and an installed
# program finds it wherever both are.
cmake_minimum_required(VERSION 3.25)
include(${settings})
start()
run(${CMAKE_COMMAND} -S ${t4d_source} -B t4d -G ${generator} -D CMAKE_CXX_COMPILER=${compiler}
  "-DCMAKE_CXX_FLAGS=${flags}" -D CMAKE_BUILD_TYPE=${build_type} -D BUILD_SHARED_LIBS=ON
  -D T4D_COMPONENTS=model -D T4D_BUILD_PROGRAM=OFF -D T4D_BUILD_PYTHON=OFF -D T4D_BUILD_TESTS=OFF
  -D T4D_BUILD_BENCHMARKS=OFF)
run(${CMAKE_COMMAND} --build t4d)
run(${CMAKE_COMMAND} --install t4d --prefix ${work_dir}/first)
file(RENAME ${work_dir}/first ${work_dir}/moved)
file(GLOB_RECURSE library RELATIVE ${work_dir}/moved ${work_dir}/moved/libt4d_model.so.0.*)
string(REGEX MATCH "libt4d_model[.]so[.]0[.][0-9]+;" named "${library};")
if(NOT named)
  message(FATAL_ERROR "there is no shared library named by the minor version: ${library}")
endif()
set(prefix ${work_dir}/moved)
configure(${CMAKE_CURRENT_LIST_DIR}/consumer -D how=find_package -D CMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build build)
run(build/consumer)
if(NOT run_output MATCHES "5 vertices, 5 cells")
  message(FATAL_ERROR "the consumer printed '${run_output}'")
endif()
