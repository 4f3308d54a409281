#!/usr/bin/env bash
# tools/toolchains/libraries.sh PREFIX [--toolchain /FOLDER/TOOLCHAIN.cmake] [OPTION...]
#
# Builds zlib, expat and libzip into PREFIX, static, from Debian's sources with their patches, and copies the headers of CLI11,
# fast_float and nlohmann's JSON there, which are the same everywhere. Nothing is installed: the lists of sources are PREFIX's
# own. Then: cmake --toolchain TOOLCHAIN.cmake -DCMAKE_FIND_ROOT_PATH=PREFIX ...
# Without a toolchain it builds for this system, and copies Debian's libcrypto.a, too; then --toolchain static.cmake.
#
# MORE="libpng1.6 hdf5 mimalloc" builds these, too, or some of them. LIBCRYPTO=NAME, as OpenSSL names the system, builds that
# library with CC, AR and RANLIB.
set -euo pipefail

mkdir -p "$1"/{sources/{lists,cache}/partial,include,lib/cmake,share/cmake}
cd "$1"
readonly prefix=$PWD options=("${@:2}") jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)} more=" ${MORE:-} "
read -ra packages <<< "zlib expat libzip $more ${LIBCRYPTO:+openssl}"

apt_of_sources() {
    apt-get -qq -o Dir::Etc::sourcelist="$prefix/sources/list" -o Dir::Etc::sourceparts=/dev/null \
        -o Dir::State::lists="$prefix/sources/lists" -o Dir::Cache="$prefix/sources/cache" -o APT::Sandbox::User= "$@"
}
if ! compgen -G "sources/zlib-*" > /dev/null; then
    echo "deb-src http://deb.debian.org/debian bookworm main" > sources/list
    apt_of_sources update
    (cd sources && apt_of_sources source --download-only "${packages[@]}")
    for description in sources/*.dsc; do
        (cd sources && dpkg-source --no-check --extract "${description##*/}")
    done
fi

# configure PACKAGE SOURCES OPTION...: arc4random is glibc's of 2.36 on, and there are other ways.
configure() {
    cmake -S "$2" -B "sources/build-$1" -G Ninja "${options[@]}" -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=OFF \
        -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DCMAKE_FIND_ROOT_PATH="$prefix" -DCMAKE_INSTALL_PREFIX="$prefix" \
        -DCMAKE_INSTALL_LIBDIR=lib -DZLIB_LIBRARY="$prefix/lib/libz.a" -DZLIB_INCLUDE_DIR="$prefix/include" \
        -DHAVE_ARC4RANDOM{,_BUF}=OFF "${@:3}"
}

# Its shared library, of which Debian leaves out a part, would be found first, and is static, too, where there are none.
zlib=$(echo sources/zlib-*)
mkdir -p "$zlib/win32" && touch "$zlib/win32/zlib1.rc"
sed -i 's/(zlib zlibstatic PROPERTIES OUTPUT_NAME z)/(zlibstatic PROPERTIES OUTPUT_NAME z)/' "$zlib/CMakeLists.txt"
configure zlib "$zlib"
cmake --build sources/build-zlib --target zlibstatic
cp sources/build-zlib/libz*.a lib/libz.a
cp sources/build-zlib/zconf.h "$zlib/zlib.h" include

# Debian's patches ask for the value that the Autotools give it.
sed -i 's/#cmakedefine XML_DTD$/#cmakedefine XML_DTD 1/' sources/expat-*/expat/expat_config.h.cmake
configure expat sources/expat-*/expat -DEXPAT_SHARED_LIBS=OFF -DEXPAT_BUILD_{TOOLS,TESTS,EXAMPLES,DOCS}=OFF
cmake --build sources/build-expat --target install

configure libzip sources/libzip-* -DBUILD_{TOOLS,REGRESS,EXAMPLES,DOC}=OFF \
    -DENABLE_{OPENSSL,GNUTLS,MBEDTLS,BZIP2,LZMA,ZSTD,COMMONCRYPTO,WINDOWS_CRYPTO}=OFF
cmake --build sources/build-libzip --target install

if [[ $more == *" libpng1.6 "* ]]; then
    configure libpng sources/libpng1.6-* -DPNG_{SHARED,TESTS}=OFF
    cmake --build sources/build-libpng --target png_static
    cp sources/build-libpng/libpng16.a lib/libpng.a
    cp sources/libpng1.6-*/png{,conf}.h sources/build-libpng/pnglibconf.h include
fi

if [[ $more == *" hdf5 "* ]]; then
    # No file may have code loaded.
    sed -i 's/dlopen(S, RTLD_LAZY.*/NULL/' sources/hdf5-*/src/H5PLpkg.h
    mkdir -p sources/build-hdf5
    (cd sources/build-hdf5 && ../hdf5-*/configure --prefix="$prefix" --disable-shared --with-pic --with-zlib="$prefix" \
        --enable-build-mode=production --disable-{hl,tests,tools} --without-szlib \
        CFLAGS="-Os -w -ffunction-sections -fdata-sections -fno-asynchronous-unwind-tables")
    make -C sources/build-hdf5/src -j "$jobs" install
fi

# As C++, in which its operator new throws and does not abort.
if [[ $more == *" mimalloc "* ]]; then
    configure mimalloc sources/mimalloc-* -DMI_USE_CXX=ON -DMI_BUILD_{SHARED,OBJECT,TESTS}=OFF -DMI_INSTALL_TOPLEVEL=ON
    cmake --build sources/build-mimalloc --target install
fi

if ((${#options[@]} == 0)); then
    cp "$(cc -print-file-name=libcrypto.a)" lib
    cp -r /usr/include/openssl "/usr/include/$(cc -print-multiarch)/openssl" include
elif [[ -n ${LIBCRYPTO:-} ]]; then
    cd sources/openssl-*
    ./Configure "$LIBCRYPTO" no-{shared,tests,dso,engine,module,comp,async}
    make -j "$jobs" build_generated
    make -j "$jobs" libcrypto.a
    cp libcrypto.a "$prefix/lib"
    cp -r include/openssl "$prefix/include"
    cd "$prefix"
fi

cp -r /usr/include/{CLI,fast_float,nlohmann} include
cp -r /usr/lib/cmake/FastFloat lib/cmake
cp -r /usr/share/cmake/{CLI11,nlohmann_json} share/cmake
