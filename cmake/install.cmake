# `find_package(t4d)` for other projects: targets t4d::model, t4d::mesh4d, t4d::voxel4d, t4d::formats,
# t4d::convert, t4d::conformance, t4d::fixtures.
include(CMakePackageConfigHelpers)
set(T4D_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/t4d)
configure_package_config_file(cmake/t4dConfig.cmake.in ${PROJECT_BINARY_DIR}/t4dConfig.cmake
  INSTALL_DESTINATION ${T4D_CMAKE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/t4dConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(EXPORT t4dTargets NAMESPACE t4d:: DESTINATION ${T4D_CMAKE_DIR})
install(FILES ${PROJECT_BINARY_DIR}/t4dConfig.cmake ${PROJECT_BINARY_DIR}/t4dConfigVersion.cmake
  cmake/FindTetGen.cmake cmake/FindISAL.cmake cmake/T4dOpenVDB.cmake
  DESTINATION ${T4D_CMAKE_DIR})
set(T4D_SCHEMA_DIR ${CMAKE_INSTALL_DATADIR}/t4d/schemas)
install(DIRECTORY docs/schemas/ DESTINATION ${T4D_SCHEMA_DIR} FILES_MATCHING PATTERN *.schema.json)
install(FILES formats/motion.schema.json formats/t4d/head.schema.json
  formats/t4d/reader_describe.schema.json formats/t4d/reader_slice.schema.json
  DESTINATION ${T4D_SCHEMA_DIR})
# As they lie in the project, so that their links lead somewhere.
install(FILES LICENSE NOTICE README.md CHANGELOG.md CONTRIBUTING.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES formats/motion.schema.json DESTINATION ${CMAKE_INSTALL_DOCDIR}/formats)
install(FILES tools/fuzz/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/tools/fuzz)
install(FILES conformance/backends/backend.h
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/conformance/backends)
install(DIRECTORY conformance/readers DESTINATION ${CMAKE_INSTALL_DOCDIR}/conformance
  USE_SOURCE_PERMISSIONS
  PATTERN node_modules EXCLUDE PATTERN __pycache__ EXCLUDE)
install(DIRECTORY tests/package DESTINATION ${CMAKE_INSTALL_DOCDIR}/tests
  FILES_MATCHING PATTERN CMakeLists.txt PATTERN *.cpp)
install(DIRECTORY formats/t4d DESTINATION ${CMAKE_INSTALL_DOCDIR}/formats
  FILES_MATCHING PATTERN SPEC.md PATTERN *.ksy PATTERN *.schema.json)
