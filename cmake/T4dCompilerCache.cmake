# Uses ccache if it is installed and no other launcher was chosen. It caches sources that use
# precompiled headers only with this sloppiness setting.
find_program(T4D_CCACHE ccache)
if(T4D_CCACHE AND PROJECT_IS_TOP_LEVEL AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
    ${T4D_CCACHE})
endif()
