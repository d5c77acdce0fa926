# OpenVDB::openvdb. OpenVDB comes with a find module of its own, which sets BUILD_SHARED_LIBS for its
# caller.
block(SCOPE_FOR VARIABLES PROPAGATE OpenVDB_FOUND)
  list(APPEND CMAKE_MODULE_PATH
    "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB" "/usr/local/lib/cmake/OpenVDB")
  t4d_find(OpenVDB 10 COMPONENTS openvdb)
endblock()
