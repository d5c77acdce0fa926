# t4d-static: the program in one file, for any Linux, which `tools/package --static` builds. It is linked of what t4d is
# compiled to, so its results are the same. Its C library is glibc: the allocator of musl is slow with several
# threads, and its sines have other last digits. It loads no modules.
set(T4D_STATIC_LIBRARIES "" CACHE PATH "Where cmake/dependencies is installed")
add_executable(t4d-static EXCLUDE_FROM_ALL module_functions.cpp
  $<FILTER:$<TARGET_OBJECTS:t4d>,EXCLUDE,/module_functions[.]cpp>)
target_compile_definitions(t4d-static PRIVATE T4D_STATIC)
target_include_directories(t4d-static PRIVATE ${PROJECT_SOURCE_DIR})
t4d_own_code(t4d-static)
set_target_properties(t4d-static PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
add_dependencies(t4d-static t4d)
foreach(component IN LISTS T4D_ENABLED_COMPONENTS)
  list(APPEND own $<TARGET_FILE:t4d_${component}>)
endforeach()
# Not the targets that t4d links, which are shared libraries. The others are Debian's own.
list(APPEND libraries $<TARGET_FILE:t4d_program> ${own} $<TARGET_FILE:t4d_report> $<TARGET_FILE:t4d_viewer>)
foreach(library tbb tet fmt tinygltf meshoptimizer isal httplib)
  file(GLOB found ${T4D_STATIC_LIBRARIES}/lib/lib${library}.a)
  if(NOT found)
    message(FATAL_ERROR "T4D_STATIC_LIBRARIES: there is no lib/lib${library}.a; `tools/package --static` makes it")
  endif()
  list(APPEND libraries ${found})
endforeach()
list(APPEND libraries stb draco zstd lz4 lzma deflate expat mpfr gmp ssl crypto brotlienc brotlidec brotlicommon z)
target_include_directories(t4d-static PRIVATE
  $<TARGET_PROPERTY:t4d_model,INTERFACE_INCLUDE_DIRECTORIES>)
target_link_libraries(t4d-static PRIVATE
  -static -Wl,--gc-sections -s -Wl,--start-group ${libraries} -Wl,--end-group Eigen3::Eigen tl::expected fmt::fmt-header-only)
