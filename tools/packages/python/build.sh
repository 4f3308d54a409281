#!/usr/bin/env bash
# python/build.sh FOLDER: makes the source distribution lamella-VERSION.tar.gz there, of which pip builds the Python package and
# the tool, and of it the wheel lamella-VERSION-cpN-cpN-manylinux_2_X_PROCESSOR.whl, which needs glibc 2.X and nothing else. The tool
# in it is static. What is built on the way stays in FOLDER/python.
set -euo pipefail
shopt -s inherit_errexit
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
source tools/packages.sh
source tools/packages/licences.sh

folder=$(realpath "$1")
version=$(lamella_version .)
readonly folder version python=/usr/bin/python3 limit_bytes=8000000
readonly work=$folder/python libraries=$folder/libraries
readonly glibc='lib(c|m|dl|rt|pthread)\.so\.[0-9]+|ld-linux.*'
mkdir -p "$work"

make_sdist() {
    (cd tools/python && "$python" setup.py --quiet sdist --formats gztar --dist-dir "$folder") > "$work/log" 2>&1 ||
        stop "the sources could not be packed: see $work/log"
}

# build_wheel: the module and the tool from the source distribution, into $work/made.
build_wheel() {
    [[ -e $libraries/lib/libmimalloc.a ]] || MORE="libpng1.6 hdf5 mimalloc" tools/toolchains/libraries.sh "$libraries" || return
    rm -rf "$work"/{made,unpacked} "$work/lamella-$version/sources"
    tar -xzf "$folder/lamella-$version.tar.gz" -C "$work"
    CCACHE_BASEDIR=$work CMAKE_GENERATOR=Ninja CMAKE_ARGS="--toolchain '$PWD/tools/toolchains/static.cmake' \
        -DCMAKE_FIND_ROOT_PATH='$libraries' -DCMAKE_CXX_COMPILER_LAUNCHER='$(command -v ccache || true)' -DLAMELLA_PARALLEL=std" \
        "$python" -m pip wheel -v --no-index --no-build-isolation --no-deps --wheel-dir "$work/made" "$work/lamella-$version" || return
    "$python" -m wheel unpack --dest "$work/unpacked" "$work"/made/*.whl
}

# tag_of FILE...: the oldest glibc that has all that they ask for. Fails where one needs another library.
tag_of() {
    local others
    others=$(objdump -p "$@" | sed -n 's/^ *NEEDED *//p' | sort -u | grep -vxE "$glibc" || true)
    [[ -z $others ]] || stop "the wheel would need ${others//$'\n'/ }"
    echo "manylinux_$(objdump -T "$@" 2> /dev/null | grep -o 'GLIBC_2\.[0-9]*' | sort -Vu | tail -1 | sed 's/GLIBC_//; s/\./_/')_$(uname -m)"
}

make_wheel() {
    local -r root=$work/unpacked/lamella-$version
    local info=$root/lamella-$version.dist-info binaries tag bytes
    build_wheel > "$work/log" 2>&1 || stop "the wheel could not be built: see $work/log"
    binaries=("$root"/lamella/_native*.so "$root/lamella/bin/lamella")
    chmod +x "${binaries[@]}"  # which wheel does not keep
    strip --strip-unneeded "${binaries[@]}"
    tag=$(tag_of "${binaries[@]}")
    copy_licences "$libraries" "$info/licenses" libssl-dev libcli11-dev pybind11-dev gcc-12-base libc6
    sed -i "s/linux_$(uname -m)/$tag/" "$info/WHEEL"
    rm -f "$folder"/lamella-*.whl
    "$python" -m wheel pack --dest-dir "$folder" "$root" > "$work/log"
    bytes=$(cat "$folder"/lamella-*.whl | wc -c)
    ((bytes <= limit_bytes)) || stop "the wheel has $bytes bytes, more than $limit_bytes"
}

install_missing "${wheel_packages[@]}"
make_sdist
make_wheel
