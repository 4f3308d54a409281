# 64-bit ARM on another Linux, by Debian's g++-aarch64-linux-gnu; what is built runs in qemu-user:
#
#     tools/toolchains/arm64_packages.sh build/arm64
#     cmake -S . -B build/aarch64 --toolchain tools/toolchains/aarch64.cmake -DLAMELLA_ARM64_ROOT=$PWD/build/arm64 \
#         -DLAMELLA_PARALLEL=std -DLAMELLA_BUILD_MEDICAL=OFF -DLAMELLA_BUILD_TESTS=OFF -DLAMELLA_BUILD_BENCH=OFF \
#         -DLAMELLA_BUILD_GOLDEN_TESTS=ON
#
# Without that folder the core and its C interface can be built: -DLAMELLA_BUILD_IO=OFF.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

set(LAMELLA_ARM64_ROOT "" CACHE PATH "Where libraries for ARM and headers of all processors are unpacked")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES LAMELLA_ARM64_ROOT)
set(CMAKE_CROSSCOMPILING_EMULATOR
    qemu-aarch64 -L /usr/aarch64-linux-gnu -E LD_LIBRARY_PATH=${LAMELLA_ARM64_ROOT}/usr/lib/aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH /usr/aarch64-linux-gnu ${LAMELLA_ARM64_ROOT})
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_LIBDIR} ${LAMELLA_ARM64_ROOT}/usr/lib/aarch64-linux-gnu/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${LAMELLA_ARM64_ROOT})
# The libraries' own libraries.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-Wl,-rpath-link,${LAMELLA_ARM64_ROOT}/usr/lib/aarch64-linux-gnu")
