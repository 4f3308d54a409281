# This system, with the libraries that libraries.sh has built inside: programs need nothing, and modules for Python glibc alone.
include(${CMAKE_CURRENT_LIST_DIR}/libraries.cmake)
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static -Wl,--gc-sections")
set(CMAKE_MODULE_LINKER_FLAGS_INIT "-static-libstdc++ -static-libgcc -Wl,--gc-sections")
