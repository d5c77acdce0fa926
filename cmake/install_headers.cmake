# Run by `cmake --install` for one folder, given: folder, headers, source_dir, include_dir.
#
# Our headers include each other from the project's root ("model/slab.h"). Installed they say
# "t4d/model/slab.h", so that only include/ need be on a user's path: with include/t4d there, a
# user's own model/slab.h would be taken for ours.
foreach(header IN LISTS headers)
  file(READ ${source_dir}/${header} text)
  string(REGEX REPLACE "(#include \")([a-z0-9_]+/)" "\\1t4d/\\2" text "${text}")
  set(target ${CMAKE_INSTALL_PREFIX}/${include_dir}/t4d/${folder}/${header})
  message(STATUS "Installing: ${target}")
  file(WRITE "$ENV{DESTDIR}${target}" "${text}")
  list(APPEND CMAKE_INSTALL_MANIFEST_FILES ${target})
endforeach()
