# Installs the t4d built in `t4d_build`, builds example.cpp against the installed package and runs
# it. Everything lies under `work_dir`.
cmake_minimum_required(VERSION 3.25)

# A failed command fails the test; its output is shown.
function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${work_dir} COMMAND_ECHO STDOUT
    COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(READ ${CMAKE_CURRENT_LIST_DIR}/example.cpp example)
file(READ ${CMAKE_CURRENT_LIST_DIR}/../../README.md readme)
string(FIND "${readme}" "${example}" found)
if(found EQUAL -1)
  message(FATAL_ERROR "the example in README.md is not tests/package/example.cpp")
endif()

file(REMOVE_RECURSE ${work_dir})
file(MAKE_DIRECTORY ${work_dir})
run(${CMAKE_COMMAND} --install ${t4d_build} --prefix ${work_dir}/installed)
foreach(schema sweep head reader_slice motion)
  if(NOT EXISTS ${work_dir}/installed/share/t4d/schemas/${schema}.schema.json)
    message(FATAL_ERROR "the JSON Schema of ${schema} is not installed")
  endif()
endforeach()
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B build -G ${generator}
  -D CMAKE_PREFIX_PATH=${work_dir}/installed -D CMAKE_CXX_COMPILER=${compiler}
  -D CMAKE_BUILD_TYPE=${build_type} "-DCMAKE_CXX_FLAGS=${flags}")
run(${CMAKE_COMMAND} --build build)
if(NOT with_tetgen)
  return()  # the example's ends are closed by TetGen
endif()

run(${fixtures_program} .)
run(build/example)
# Binary STL: 84 bytes, and 50 a triangle; a slice has no fewer triangles than the bolt's surface.
file(SIZE ${work_dir}/bolt-at-2.5.stl bytes)
math(EXPR rest "(${bytes} - 84) % 50")
if(bytes LESS 100000 OR NOT rest EQUAL 0)
  message(FATAL_ERROR "bolt-at-2.5.stl has ${bytes} bytes: not the STL of a bolt")
endif()
