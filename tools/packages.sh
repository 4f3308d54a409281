# Sourced by the other scripts: lists the Debian packages that the project needs, and installs missing ones.

build_packages=(
    cmake ninja-build g++
    libtbb-dev libmimalloc-dev catch2 libcli11-dev nlohmann-json3-dev libfast-float-dev
    zlib1g-dev libexpat1-dev libzip-dev pkg-config
    libssl-dev libpng-dev libhdf5-dev
)
# bench/: the second is only compared with.
bench_packages=(libbenchmark-dev libpolyclipping-dev python3-numpy python3-matplotlib time)
test_packages=(libxml2-utils libcgal-dev python3)
# tools/python: the package needs numpy, the others are for its tests.
python_packages=(
    python3-dev pybind11-dev python3-numpy python3-setuptools python3-wheel python3-pip python3-venv
    python3-pytest python3-pandas python3-shapely python3-matplotlib python3-tqdm mypy
)
# tests/readers: programs that read what lamella::medical writes. A test whose program is missing is skipped.
reader_packages=(dcmtk dicom3tools python3-nibabel python3-pydicom python3-h5py python3-pandas python3-pil python3-vtk9 python3-skimage plastimatch teem-apps
  lib3mf1 python3-ezdxf python3-shapely gdal-bin)
# tests/cluster: the engines that tools/cluster and the Python package hand meshes to.
cluster_packages=(slurm-wlm munge snakemake python3-distributed python3-pandas)
# tools/cluster/image.sh: the third runs, in its test, what the first makes.
image_packages=(buildah mmdebstrap runc)
check_packages=(clang clang-format clang-tidy libclang-rt-14-dev doxygen abigail-tools)
picture_packages=(librsvg2-bin)
# tools/platforms.sh: compilers for other systems, and what runs their programs. The golden slices need the first alone.
golden_packages=(g++-mingw-w64-x86-64-posix wine64 emscripten nodejs g++-aarch64-linux-gnu qemu-user)
platform_packages=(dpkg-dev clang-19)
# tools/view: the page that slices, and the browser that its tests open it in.
page_packages=(emscripten nodejs dpkg-dev libfast-float-dev nlohmann-json3-dev)
command -v npm > /dev/null || page_packages+=(npm)  # other packages of node bring it, and conflict with Debian's
page_test_packages=(chromium)
# tools/packages: the wheel, in which the program for Linux is; the program for Windows; what makes packages for Debian, reads them,
# and the system that they are tried in.
wheel_packages=("${build_packages[@]}" dpkg-dev make "${python_packages[@]:0:7}")
windows_packages=("${build_packages[@]}" dpkg-dev make g++-mingw-w64-x86-64-posix wine64)
deb_packages=(debhelper dh-python dpkg-dev lintian mmdebstrap git python3-dev pybind11-dev python3-numpy python3-setuptools)

# lamella_version ROOT
lamella_version() { sed -n 's/.* version = "\(.*\)".*/\1/p' "$1/include/lamella/version.hpp"; }

# stop MESSAGE: prints one line on stderr and ends the script.
stop() {
    echo "error: $1" >&2
    exit 1
}

# install_missing PACKAGE...: installs those that are missing. Does not ask for root if none is.
install_missing() {
    local package missing=() as_root=()
    for package in "$@"; do
        [[ "$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2> /dev/null)" == installed ]] || missing+=("$package")
    done
    ((${#missing[@]} > 0)) || return 0
    ((EUID == 0)) || as_root=(sudo)
    echo "Installing ${missing[*]} (apt-get, needs root and the network)"
    # apt-get update succeeds without a network, so only the installation shows whether packages can be had.
    "${as_root[@]}" apt-get update -qq || true
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" > /dev/null ||
        stop "packages of Debian 12 are missing; as root: apt-get install ${missing[*]}"
}
