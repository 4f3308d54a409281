# WebAssembly by emscripten, one thread; -DLAMELLA_WASM_THREADS=ON: with threads. Programs run in node and see its files.
include(/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/libraries.cmake)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES LAMELLA_WASM_THREADS)
set(flags -fwasm-exceptions)
set(memory -sALLOW_MEMORY_GROWTH=1)
if(LAMELLA_WASM_THREADS)
  string(APPEND flags " -pthread")
  # A thread that does not wait in the pool starts only when main() is over. Memory that grows is slow to reach from others.
  set(memory "-sINITIAL_MEMORY=1GB -sPTHREAD_POOL_SIZE=8")
endif()
set(CMAKE_C_FLAGS_INIT "${flags}")
set(CMAKE_CXX_FLAGS_INIT "${flags}")
set(CMAKE_EXE_LINKER_FLAGS_INIT "${memory} -sNODERAWFS=1 -sEXIT_RUNTIME=1")
set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
# emscripten 3.1 takes the fetch() of later versions of node for that of a browser.
set(CMAKE_CROSSCOMPILING_EMULATOR /usr/bin/node --no-experimental-fetch)
