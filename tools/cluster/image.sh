#!/usr/bin/env bash
# image.sh ARCHIVE [BUILD]: makes an OCI image of the tool in a build folder (build/), and writes it to one file.
#
#     tools/cluster/image.sh lamella.tar
#     podman run --rm -v "$PWD:$PWD" -w "$PWD" oci-archive:lamella.tar slice bone.stl --hash
#
# - The system in it is this machine's Debian, from whose libraries the tool was built. mmdebstrap fetches the packages from Debian's mirrors, and buildah
#   writes the image: no registry and no daemon is needed.
# - Packages are extracted and not configured. They are those that hold the tool's libraries, what these depend on, and a shell,
#   which Apptainer needs. Manuals, translations and converters of character sets are left out; licences stay.
set -euo pipefail
shopt -s inherit_errexit
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
source "$root/tools/packages.sh"

(($# == 1 || $# == 2)) || stop "usage: $0 ARCHIVE [BUILD]"
archive="$(realpath "$1")"
build="$(realpath "${2:-$root/build}")"
[[ -x "$build/tools/lamella" ]] || stop "$build has no tool: cmake --build $build --target lamella_cli"
install_missing "${image_packages[@]}"
work="$(mktemp -d)"
aside="$archive.$$.part"
trap 'rm -rf "$work" "$aside"' EXIT

# quietly COMMAND...: prints the command's output only if it fails.
quietly() {
    "$@" > "$work/log" 2>&1 || {
        cat "$work/log" >&2
        stop "failed: $*"
    }
}

# packages_of PROGRAM: where its libraries come from. Some packages still name them below /lib, which is /usr/lib.
packages_of() {
    ldd "$1" | sed -n 's|.* => .*\(lib/.*\) (0x.*|*/\1|p' | xargs dpkg-query --search | cut -d: -f1 | sort -u
}

# In folders of its own: nothing of the user's images is read or changed. "vfs" needs nothing of the file system.
buildah() { command buildah --root "$work/storage" --runroot "$work/run" --storage-driver vfs "$@"; }

source /etc/os-release
packages="$(packages_of "$build/tools/lamella")"
version="$("$build/tools/lamella" --version)"
version="${version##* }"
quietly mmdebstrap --variant=extract --include="base-files dash ${packages//$'\n'/ }" \
    --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-include=/usr/share/doc/*/copyright' \
    --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/locale/*' \
    --dpkgopt='path-exclude=*/gconv/*' "$VERSION_CODENAME" "$work/system.tar"
DESTDIR="$work/tool" quietly cmake --install "$build" --component tool --strip --prefix /usr/local
install -D --mode=644 --target-directory="$work/tool/usr/local/share/licenses/lamella" "$root/LICENSE"
# Some libraries are linked into the tool, or are headers alone: libhdf5-dev brings libaec-dev.
for package in "${build_packages[@]}" libaec-dev; do
    text="/usr/share/doc/$package/copyright"
    [[ "$package" != *-dev || ! -e "$text" ]] || install -D --mode=644 "$text" "$work/tool$text"
done

container="$(buildah from scratch)"
quietly buildah add "$container" "$work/system.tar" /
quietly buildah copy --chown 0:0 "$container" "$work/tool" /
quietly buildah config --entrypoint '["lamella"]' --env PATH=/usr/local/bin:/usr/bin:/bin \
    --label org.opencontainers.image.title=lamella --label org.opencontainers.image.version="$version" \
    --label org.opencontainers.image.licenses=Apache-2.0 "$container"
quietly buildah commit "$container" "oci-archive:$aside:lamella:$version"
mv "$aside" "$archive"
echo "$archive: lamella $version, $(($(stat --format=%s "$archive") / 1000000)) MB"
