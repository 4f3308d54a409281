# Clang 19 with its libc++, which -DLAMELLA_LIBCXX=FOLDER holds unpacked: Debian installs one version of it beside others at most.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES LAMELLA_LIBCXX)
set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
set(folder ${LAMELLA_LIBCXX}/usr/lib/llvm-19)
set(CMAKE_CXX_FLAGS_INIT "-nostdinc++ -isystem ${folder}/include/c++/v1")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-stdlib=libc++ -L${folder}/lib -Wl,-rpath,${folder}/lib")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "${CMAKE_EXE_LINKER_FLAGS_INIT}")
