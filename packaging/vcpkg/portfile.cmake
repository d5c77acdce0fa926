# A port of this checkout: `vcpkg install t4d --overlay-ports=packaging/vcpkg`. The ends of a sweep are closed by a
# cone: vcpkg has no TetGen. A TetGen of one's own is found with -DT4D_WITH_TETGEN=ON.
get_filename_component(SOURCE_PATH ${CMAKE_CURRENT_LIST_DIR}/../.. ABSOLUTE)
vcpkg_check_features(OUT_FEATURE_OPTIONS features
  FEATURES
    cgal T4D_WITH_CGAL
    curl T4D_WITH_CURL
    draco T4D_WITH_DRACO
    meshoptimizer T4D_WITH_MESHOPTIMIZER)
vcpkg_cmake_configure(SOURCE_PATH ${SOURCE_PATH}
  OPTIONS ${features}
    -DT4D_WITH_TETGEN=OFF -DT4D_BUILD_PROGRAM=OFF -DT4D_BUILD_READER=OFF -DT4D_BUILD_TESTS=OFF
    -DT4D_BUILD_BENCHMARKS=OFF -DT4D_BUILD_PYTHON=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/t4d)
file(REMOVE_RECURSE ${CURRENT_PACKAGES_DIR}/debug/include ${CURRENT_PACKAGES_DIR}/debug/share)
vcpkg_install_copyright(FILE_LIST ${SOURCE_PATH}/LICENSE ${SOURCE_PATH}/NOTICE)
