# A Debian package of program, library, Python module and pages: tools/package makes it.
set(T4D_CONTACT "The t4d authors <authors@t4d.invalid>" CACHE STRING "Who answers for the package")
set(T4D_PAGES ${PROJECT_BINARY_DIR}/pages)
# Made from the help texts of the program.
add_custom_target(manuals
  COMMAND ${PROJECT_SOURCE_DIR}/tools/pages/manuals $<TARGET_FILE:t4d> ${T4D_PAGES}/man
  COMMAND ${PROJECT_SOURCE_DIR}/tools/pages/completions $<TARGET_FILE:t4d> ${T4D_PAGES}/completions
  COMMAND gzip -9nkf ${T4D_PAGES}/changelog
  VERBATIM)
add_dependencies(manuals t4d)
# What Debian's policy asks for beside the pages.
file(WRITE ${T4D_PAGES}/copyright "Copyright 2026 The t4d authors

Licensed under the Apache License, Version 2.0: /usr/share/common-licenses/Apache-2.0. The file
NOTICE beside this one lists the libraries that are linked, and their licences.
")
string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${T4D_PAGES}/changelog
  "t4d (${PROJECT_VERSION}) unstable; urgency=medium\n\n  * See CHANGELOG.md beside this file.\n\n -- ${T4D_CONTACT}  ${now}\n")
install(FILES ${T4D_PAGES}/copyright ${T4D_PAGES}/changelog.gz DESTINATION ${CMAKE_INSTALL_DOCDIR}
  OPTIONAL)
install(DIRECTORY ${T4D_PAGES}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL)
install(DIRECTORY ${T4D_PAGES}/completions/ DESTINATION ${CMAKE_INSTALL_DATADIR} OPTIONAL
  PATTERN zsh EXCLUDE)
install(FILES ${T4D_PAGES}/completions/zsh/site-functions/_t4d OPTIONAL
  DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(DIRECTORY ${T4D_PAGES}/site/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/html OPTIONAL)

# What Python has compiled goes with the module.
file(WRITE ${T4D_PAGES}/prerm "#!/bin/sh
set -e
if command -v py3clean >/dev/null; then py3clean --package t4d; fi
")
file(CHMOD ${T4D_PAGES}/prerm PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
  GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${T4D_PAGES}/prerm)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "${T4D_CONTACT}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "4D meshes: the boundary of a moving solid in space-time")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
  "Sweeps solids along motions, weaves time series of voxel grids, slices,\n animates, checks and converts the result, and answers questions about motion.\n With the C++ library, the Python module t4d and the pages.")
set(CPACK_DEBIAN_PACKAGE_SECTION math)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "python3, python3-numpy")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libeigen3-dev, libfmt-dev, libtbb-dev, python3-distributed")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/package)
include(CPack)
