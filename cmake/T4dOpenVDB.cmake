# OpenVDB::openvdb and TBB::tbb. OpenVDB comes with a find module of its own, which must not find
# another TBB and sets BUILD_SHARED_LIBS for whoever calls it.
find_package(TBB CONFIG REQUIRED)
block(SCOPE_FOR VARIABLES)
  list(APPEND CMAKE_MODULE_PATH
    "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB" "/usr/local/lib/cmake/OpenVDB")
  find_package(OpenVDB 10 REQUIRED COMPONENTS openvdb)
endblock()
