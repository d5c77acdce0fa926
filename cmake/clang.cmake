# The clang that `tools/setup fuzz` installs, for the preset asan. Which versions there are depends on the
# system; the first of these has been used most.
find_program(T4D_CLANG clang++-16 clang++-19 clang++-18 clang++-17)
if(NOT T4D_CLANG)
  message(FATAL_ERROR "there is no clang++-16 to clang++-19; tools/setup fuzz installs one")
endif()
set(CMAKE_CXX_COMPILER ${T4D_CLANG})
string(REPLACE "clang++" "clang" CMAKE_C_COMPILER ${T4D_CLANG})
