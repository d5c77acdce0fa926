# A .pc file for each component, t4d-<component>.pc, for builds without CMake. What a component links
# is read from its target.
set(T4D_LINKED
  "TBB::tbb=-ltbb" "fmt::fmt=-lfmt" "ZLIB::ZLIB=-lz" "ISAL::ISAL=-lisal"
  "EXPAT::EXPAT=-lexpat" "LZ4::LZ4=-llz4"
  "zstd::libzstd_shared=-lzstd"
  "TinyGLTF::TinyGLTF=-ltinygltf" "LibLZMA::LibLZMA=-llzma"
  "LibDeflate::LibDeflate=-ldeflate" "CURL::libcurl=-lcurl"
  "meshoptimizer::meshoptimizer=-lmeshoptimizer" "draco::draco=-ldraco" "TetGen::TetGen=-ltet"
  "CGAL::CGAL=-lmpfr -lgmp")
if(IS_ABSOLUTE ${CMAKE_INSTALL_LIBDIR} OR IS_ABSOLUTE ${CMAKE_INSTALL_INCLUDEDIR})
  message(FATAL_ERROR "CMAKE_INSTALL_LIBDIR and CMAKE_INSTALL_INCLUDEDIR are below the prefix of the installation")
endif()
file(RELATIVE_PATH to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" to_prefix ${to_prefix})

foreach(component IN LISTS T4D_ENABLED_COMPONENTS)
  get_target_property(links t4d_${component} LINK_LIBRARIES)
  set(requires)
  set(others)
  foreach(link IN LISTS links)
    set(flags ${T4D_LINKED})
    list(FILTER flags INCLUDE REGEX "^${link}=")
    if(link MATCHES "^t4d::(.*)")
      list(APPEND requires "t4d-${CMAKE_MATCH_1} = ${PROJECT_VERSION}")
    elseif(link STREQUAL "Eigen3::Eigen")
      list(APPEND requires eigen3)
    elseif(link STREQUAL "OpenVDB::openvdb")
      list(APPEND requires Imath)  # of the half floats in its headers
      list(APPEND others -lopenvdb)
    elseif(flags)
      string(REGEX REPLACE "^.*=" "" flags "${flags}")
      list(APPEND others ${flags})
    elseif(NOT link MATCHES "^[$]<BUILD_INTERFACE:")
      message(FATAL_ERROR "cmake/pkgconfig.cmake does not know how ${link} is linked")
    endif()
  endforeach()
  list(JOIN requires ", " requires)
  list(JOIN others " " others)
  # A static library brings nothing along.
  if(BUILD_SHARED_LIBS)
    set(others "\nLibs.private: ${others}")
  else()
    set(others " ${others}")
  endif()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/pkgconfig/t4d-${component}.pc @ONLY CONTENT
"prefix=\${pcfiledir}/@to_prefix@
libdir=\${prefix}/@CMAKE_INSTALL_LIBDIR@
includedir=\${prefix}/@CMAKE_INSTALL_INCLUDEDIR@

Name: t4d-@component@
Description: 4D meshes (the boundary of a moving solid in space-time): the component @component@
Version: @PROJECT_VERSION@
Requires: @requires@
Cflags: -I\${includedir} -I\${includedir}/t4d/third_party
Libs: -L\${libdir} -lt4d_@component@@others@
")
  install(FILES ${PROJECT_BINARY_DIR}/pkgconfig/t4d-${component}.pc
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
