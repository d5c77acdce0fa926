# ccache, where it is installed and nobody has chosen another launcher. It caches what is compiled
# with precompiled headers only with this sloppiness.
find_program(T4D_CCACHE ccache)
if(T4D_CCACHE AND PROJECT_IS_TOP_LEVEL AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
    ${T4D_CCACHE})
endif()
