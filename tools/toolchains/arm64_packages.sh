#!/usr/bin/env bash
# tools/toolchains/arm64_packages.sh FOLDER
#
# Unpacks what lamella::io and its golden tests need for ARM into FOLDER, from Debian's packages. Nothing is installed: the lists
# of packages are FOLDER's own.
set -euo pipefail

readonly packages=(
    zlib1g zlib1g-dev libexpat1 libexpat1-dev libzip4 libzip-dev libbz2-1.0 liblzma5 libzstd1 libssl3
    libfast-float-dev nlohmann-json3-dev catch2
)
mkdir -p "$1"/{lists/partial,cache/archives/partial,debs}
cd "$1"
readonly folder=$PWD
apt_for_arm() {
    apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State::lists="$folder/lists" \
        -o Dir::Cache="$PWD/cache" -o Acquire::Languages=none -o APT::Sandbox::User= "$@"
}
if [[ ! -e usr/lib/aarch64-linux-gnu/libzip.so ]]; then
    apt_for_arm update
    (cd debs && apt_for_arm download "${packages[@]}")
    for package in debs/*.deb; do
        dpkg-deb --extract "$package" .
    done
    # Links that name the folder of an installed system.
    cp --archive lib/aarch64-linux-gnu/. usr/lib/aarch64-linux-gnu
    for link in usr/lib/aarch64-linux-gnu/*.so; do
        [[ ! -L "$link" ]] || ln --symbolic --force "$(basename "$(readlink "$link")")" "$link"
    done
fi
