# `find_package(t4d)` for other projects: targets t4d::model, t4d::mesh4d, t4d::voxel4d, t4d::formats,
# t4d::convert, t4d::conformance.
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
install(FILES LICENSE NOTICE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
