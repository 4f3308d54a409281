# Sourced by the scripts beside it: the Debian packages that the project needs, and how missing ones are installed.

build_packages=(
    cmake ninja-build g++
    libtbb-dev libmimalloc-dev libbenchmark-dev catch2 libcli11-dev nlohmann-json3-dev libfast-float-dev
    zlib1g-dev libexpat1-dev libminizip-dev libpolyclipping-dev pkg-config
)
check_packages=(clang clang-format clang-tidy libclang-rt-14-dev libxml2-utils libcgal-dev python3)
picture_packages=(librsvg2-bin)

is_installed() {
    [[ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" == installed ]]
}

# Installs those of the packages named that are missing; asks for nothing where none is.
install_missing() {
    local package missing=() as_root=()
    for package in "$@"; do
        is_installed "$package" || missing+=("$package")
    done
    if ((${#missing[@]} == 0)); then
        return
    fi
    ((EUID == 0)) || as_root=(sudo)
    echo "installing: ${missing[*]}"
    "${as_root[@]}" apt-get update -qq
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
}
