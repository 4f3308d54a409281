#!/usr/bin/env bash
# sources/build.sh FOLDER: packs what is committed into lamella-VERSION-sources.tar.gz there, for CMake's FetchContent.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
source "$root/tools/packages.sh"
name=lamella-$(lamella_version "$root")
git -C "$root" archive --prefix="$name/" -o "$(realpath "$1")/$name-sources.tar.gz" HEAD
