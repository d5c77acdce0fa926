# The components of the library in the order of their dependencies, what each needs of the others,
# and what it needs of other packages. Read by the build and by the installed package.
set(t4d_ALL_COMPONENTS
  model system fixtures mesh4d voxel4d formats convert measure edit conformance)

set(t4d_model_NEEDS)
set(t4d_system_NEEDS model)
set(t4d_fixtures_NEEDS model)
set(t4d_mesh4d_NEEDS model)
set(t4d_voxel4d_NEEDS system)
set(t4d_formats_NEEDS system)
set(t4d_convert_NEEDS formats)
set(t4d_measure_NEEDS convert)
set(t4d_edit_NEEDS measure)
set(t4d_conformance_NEEDS fixtures mesh4d voxel4d edit)

# t4d_with_needs(<variable> <components>): those and all that they need, in order.
function(t4d_with_needs variable)
  set(wanted ${ARGN})
  set(result)
  set(backwards ${t4d_ALL_COMPONENTS})
  list(REVERSE backwards)
  foreach(component IN LISTS backwards)
    if(component IN_LIST wanted)
      list(PREPEND result ${component})
      list(APPEND wanted ${t4d_${component}_NEEDS})
    endif()
  endforeach()
  set(${variable} ${result} PARENT_SCOPE)
endfunction()

# t4d_find_packages(<component>): what a component needs besides other components. Not listed are
# packages of which only headers are used, and only to build the library. Who calls it defines
# t4d_find(<package> ...).
macro(t4d_find_packages component)
  if("${component}" STREQUAL "model")
    t4d_find(Eigen3 3.4)
  else()
    t4d_find(fmt)
  endif()
  if("${component}" STREQUAL "mesh4d")
    if(T4D_WITH_TETGEN)
      set(CGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE TRUE)
      t4d_find(TetGen)
      t4d_find(CGAL)
    endif()
  elseif("${component}" STREQUAL "voxel4d")
    # Before OpenVDB, whose find module must not find another TBB.
    t4d_find(TBB CONFIG)
    include(T4dOpenVDB)
  elseif("${component}" STREQUAL "formats")
    t4d_find(TinyGLTF)
    t4d_find(zstd)
    t4d_find(ISAL)
  elseif("${component}" STREQUAL "conformance")
    t4d_find(LibMd)
  endif()
endmacro()
