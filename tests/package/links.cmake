# Each component links what its row in docs/library.md says, with what that needs, and nothing else.
# Programs that hold all of `slice` and of `measure` show that these call nothing else either.
cmake_minimum_required(VERSION 3.25)
include(${settings})
start()
file(READ ${t4d_source}/docs/library.md page)
set(libraries
  "Eigen=Eigen3::Eigen" "TetGen=TetGen::TetGen" "CGAL=CGAL" "oneTBB=TBB::tbb"
  "OpenVDB=OpenVDB::openvdb" "zlib=ZLIB::ZLIB" "ISA-L=ISAL::ISAL"
  "Expat=EXPAT::EXPAT" "tinygltf=TinyGLTF::TinyGLTF" "zstd=zstd::libzstd_shared" "LZ4=LZ4::LZ4"
  "liblzma=LibLZMA::LibLZMA" "libcurl=CURL::libcurl"
  "meshoptimizer=meshoptimizer::meshoptimizer" "Draco=draco::draco" "libdeflate=LibDeflate::LibDeflate")
# What all components need, and solids for tests, have no rows.
set(with_rows ${components})
list(REMOVE_ITEM with_rows platform fixtures)

foreach(component IN LISTS with_rows)
  if(NOT page MATCHES "\n[|] `t4d::${component}` [|][^|]*[|]([^|]*)[|]")
    message(FATAL_ERROR "docs/library.md has no row of t4d::${component}")
  endif()
  set(needs "${CMAKE_MATCH_1}")
  set(allowed fmt::fmt t4d::model t4d::platform t4d::fixtures ${allowed_of_model})
  foreach(other IN LISTS with_rows)
    if(needs MATCHES "`${other}`|all of the above")
      list(APPEND allowed t4d::${other} ${allowed_of_${other}})
    endif()
  endforeach()
  foreach(row IN LISTS libraries)
    string(REGEX REPLACE "=.*" "" name "${row}")
    if(needs MATCHES "[ ]${name}[ ,;]|all of the above")
      string(REGEX REPLACE ".*=" "" target "${row}")
      list(APPEND allowed ${target})
    endif()
  endforeach()
  set(allowed_of_${component} ${allowed})
  file(GLOB_RECURSE exported ${prefix}/t4d-${component}.cmake)
  file(STRINGS ${exported} links REGEX INTERFACE_LINK_LIBRARIES LIMIT_COUNT 1)
  string(REGEX MATCHALL "[A-Za-z0-9_]+(::[A-Za-z0-9_]+)?" links "${links}")
  list(REMOVE_ITEM links INTERFACE_LINK_LIBRARIES LINK_ONLY)
  foreach(link IN LISTS links)
    if(NOT link IN_LIST allowed)
      message(FATAL_ERROR "t4d::${component} links ${link}, which docs/library.md does not say")
    endif()
  endforeach()
endforeach()

file(WRITE ${work_dir}/project/CMakeLists.txt "
cmake_minimum_required(VERSION 3.25)
project(links LANGUAGES CXX)
find_package(t4d REQUIRED COMPONENTS slice measure)
file(WRITE main.cpp \"int main() {}\")
foreach(component slice measure)
  add_executable(all_of_\${component} main.cpp)
  target_link_libraries(all_of_\${component} PRIVATE
    \"$<LINK_LIBRARY:WHOLE_ARCHIVE,t4d::\${component}>\")
endforeach()
")
configure(project -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_BUILD_TYPE=)
run(${CMAKE_COMMAND} --build build)
