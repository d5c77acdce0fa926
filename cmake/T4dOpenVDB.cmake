# OpenVDB::openvdb. OpenVDB's own find module sets BUILD_SHARED_LIBS in its caller's scope, hence
# the block.
block(SCOPE_FOR VARIABLES PROPAGATE OpenVDB_FOUND)
  list(APPEND CMAKE_MODULE_PATH
    "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB" "/usr/local/lib/cmake/OpenVDB")
  t4d_find(OpenVDB 10 COMPONENTS openvdb)
endblock()
