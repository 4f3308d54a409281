# zig's Clang, libraries and linker: -DLAMELLA_ZIG=ITS_PROGRAM, and -DLAMELLA_ZIG_TARGET=x86_64-linux-musl, whose programs are
# static and run on any Linux, or x86_64-macos or aarch64-macos, whose programs this machine cannot run.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES LAMELLA_ZIG LAMELLA_ZIG_TARGET)
set(CMAKE_SYSTEM_NAME Linux)
if(LAMELLA_ZIG_TARGET MATCHES macos)
  set(CMAKE_SYSTEM_NAME Darwin)
endif()
string(REGEX MATCH "^[^-]+" CMAKE_SYSTEM_PROCESSOR "${LAMELLA_ZIG_TARGET}")
set(CMAKE_C_COMPILER "${LAMELLA_ZIG}" cc -target ${LAMELLA_ZIG_TARGET})
set(CMAKE_CXX_COMPILER "${LAMELLA_ZIG}" c++ -target ${LAMELLA_ZIG_TARGET})
# A program and its first word are no program for CMake.
foreach(language C CXX)
  set(CMAKE_${language}_ARCHIVE_CREATE "\"${LAMELLA_ZIG}\" ar qc <TARGET> <LINK_FLAGS> <OBJECTS>")
  set(CMAKE_${language}_ARCHIVE_APPEND "\"${LAMELLA_ZIG}\" ar q <TARGET> <LINK_FLAGS> <OBJECTS>")
  set(CMAKE_${language}_ARCHIVE_FINISH "\"${LAMELLA_ZIG}\" ranlib <TARGET>")
endforeach()
include(${CMAKE_CURRENT_LIST_DIR}/libraries.cmake)
set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
