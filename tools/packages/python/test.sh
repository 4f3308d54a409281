#!/usr/bin/env bash
# python/test.sh TOOL FOLDER: as root, tries the wheel and the source distribution in FOLDER.
#
# TOOL is lamella of the sources: the packages must give its hash. The wheel is used where the libraries that the sources are
# built with are hidden, but for expat and zlib, which Python needs. The other is built, in minutes, where no repository is.
set -euo pipefail
shopt -s inherit_errexit
tool=$(realpath "$1")
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
folder=$(realpath "$2")
source "$root/tools/packages.sh"
sdist=lamella-$(lamella_version "$root").tar.gz
readonly tool root folder sdist
at=$(mktemp -d)
readonly at
trap 'rm -rf "$at"' EXIT

# apart COMMANDS WORD...: runs them in bash with mounts of their own.
apart() { unshare --mount bash -euo pipefail -c "$@"; }

# new_environment NAME PACKAGE
new_environment() {
    /usr/bin/python3 -m venv --system-site-packages "$at/$1"
    "$at/$1/bin/pip" --quiet --disable-pip-version-check install --no-index --no-build-isolation --no-deps "$2"
}

cp "$folder"/lamella-*.whl "$folder/$sdist" "$at"
cd "$at"
"$tool" make bone --triangles 20000 -o bone.stl > /dev/null
expected=$("$tool" slice bone.stl --layer-height 0.2 --hash | sed -n 's/^hash *//p')
[[ ${#expected} == 16 ]] || stop "$tool prints no hash"
cat > use.py << 'END'
import ctypes
import pathlib
import sys

import lamella

hidden = sys.argv[2:]
for name in hidden:
    try:
        ctypes.CDLL(name)
    except OSError:
        continue
    sys.exit(f"{name} is not hidden")
result = lamella.slice("bone.stl", layer_height=0.2)
assert result.hash == sys.argv[1], result.hash
lamella.save_mask("bone.nii.gz", "bone.stl", spacing=1, frame="ras")
assert pathlib.Path("bone.nii.gz").read_bytes()[:2] == b"\x1f\x8b"
lamella.save_picture("bone.png", result)
assert pathlib.Path("bone.png").read_bytes()[:4] == b"\x89PNG"
if hidden:
    lamella.save_archive("bone.h5", result)
    assert lamella.open("bone.h5").hash == sys.argv[1]
END
# used NAME HIDDEN...: the environment's package and its tool.
readonly used='
    LD_BIND_NOW=1 "$1/bin/python" use.py "${@:2}"
    [[ $("$1/bin/lamella" slice bone.stl --layer-height 0.2 --hash) == *"$2"* ]]'

new_environment wheel ./*.whl
apart 'for file in /usr/lib/*/lib{tbb,zip,hdf5_serial,png16,crypto,mimalloc,sz,aec}.so.*; do
        [[ -L $file ]] || mount --bind /dev/null "$file"
    done
    '"$used" bash wheel "$expected" libtbb.so.12 libzip.so.4 libhdf5_serial.so.103 libpng16.so.16 libcrypto.so.3
[[ -n $(compgen -G "wheel/lib/python3*/site-packages/lamella-*.dist-info/licenses/hdf5") ]] || stop "the wheel lacks licences"
echo "the wheel cuts the same without the libraries of the sources: $expected"

# As it is built by whoever has not all that it takes: one line says what is missing.
said=$(apart 'mount -t tmpfs none /usr/lib/cmake/FastFloat
    "$1/bin/pip" install --no-index --no-build-isolation --no-deps "./$2" 2>&1' bash wheel "$sdist" || true)
[[ $said == *"lamella: "*" is missing; on Debian, as root: apt-get install libfast-float-dev"* ]] || stop "it says what is missing by: $said"

export CMAKE_ARGS="-DLAMELLA_LARGE_UNITS=ON -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O1 -DCMAKE_CXX_COMPILER_LAUNCHER=$(command -v ccache || true)"
/usr/bin/python3 -m venv --system-site-packages sources
apart 'mount -t tmpfs none "$3"
    "$1/bin/pip" install -v --no-index --no-build-isolation --no-deps "./$2" > log 2>&1' bash sources "$sdist" "$root" ||
    stop "the sources could not be built: $(tail -20 log)"
grep -q "lamella: compiling the engine" log && grep -qE '^ *\[ *[0-9/]+%?\] Building' log || stop "the build shows no progress"
! grep -qF "$root/" log || stop "the build names the repository"
bash -euo pipefail -c "$used" bash sources "$expected"
echo "built from the source distribution, it cuts the same"
