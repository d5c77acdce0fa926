# `find_package(t4d COMPONENTS ...)` for other projects, the schemas, and the pages.
include(CMakePackageConfigHelpers)
set(T4D_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/t4d)
configure_package_config_file(cmake/t4dConfig.cmake.in ${PROJECT_BINARY_DIR}/t4dConfig.cmake
  INSTALL_DESTINATION ${T4D_CMAKE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/t4dConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/t4dConfig.cmake ${PROJECT_BINARY_DIR}/t4dConfigVersion.cmake
  cmake/components.cmake cmake/FindTetGen.cmake cmake/FindISAL.cmake cmake/FindLibDeflate.cmake
  cmake/FindLZ4.cmake cmake/T4dOpenVDB.cmake
  DESTINATION ${T4D_CMAKE_DIR})
include(cmake/pkgconfig.cmake)
# Result is tl::expected, a single public-domain header: users need no package for it.
find_path(T4D_EXPECTED_DIR tl/expected.hpp REQUIRED)
install(FILES ${T4D_EXPECTED_DIR}/tl/expected.hpp
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/t4d/third_party/tl)

set(T4D_SCHEMA_DIR ${CMAKE_INSTALL_DATADIR}/t4d/schemas)
install(FILES formats/motion/motion.schema.json formats/motion/mechanism.schema.json
  convert/frames_manifest.schema.json
  formats/t4d/head.schema.json
  formats/t4d/manifest.schema.json
  formats/t4d/reader_describe.schema.json formats/t4d/reader_slice.schema.json
  formats/t4d/writer_mesh.schema.json
  DESTINATION ${T4D_SCHEMA_DIR})
# Installed at the same relative paths as in the project, so that their links work.
install(FILES LICENSE NOTICE README.md CHANGELOG.md CONTRIBUTING.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs examples DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES formats/motion/motion.schema.json formats/motion/mechanism.schema.json
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/formats/motion)
install(FILES tools/fuzz/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/tools/fuzz)
install(FILES include/t4d/conformance.h DESTINATION ${CMAKE_INSTALL_DOCDIR}/include/t4d)
install(DIRECTORY conformance/readers DESTINATION ${CMAKE_INSTALL_DOCDIR}/conformance
  USE_SOURCE_PERMISSIONS
  PATTERN node_modules EXCLUDE PATTERN __pycache__ EXCLUDE)
install(DIRECTORY formats/t4d DESTINATION ${CMAKE_INSTALL_DOCDIR}/formats
  FILES_MATCHING PATTERN SPEC.md PATTERN *.ksy PATTERN *.schema.json)
if(T4D_BUILD_PROGRAM)
  include(${PROJECT_SOURCE_DIR}/cmake/package.cmake)
endif()
