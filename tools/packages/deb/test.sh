#!/usr/bin/env bash
# deb/test.sh TOOL FOLDER: installs the packages in FOLDER in a clean Debian. They must slice as TOOL does.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
source "$root/tools/packages.sh"
tool=$(realpath "$1")
folder=$(realpath "$2")
work=$(mktemp -d)
readonly root tool folder work system=$work/system
trap 'rm -rf "$work"' EXIT
install_missing "${deb_packages[@]}"

mmdebstrap --variant=apt --include="gcc libc6-dev pkg-config" --customize-hook="cp '$folder'/*.deb \"\$1/tmp\"" \
    --customize-hook='chroot "$1" sh -c "apt-get install -y --no-install-recommends /tmp/*.deb"' \
    bookworm "$system" > "$work/log" 2>&1 ||
    stop "they cannot be installed: $(tail -n 20 "$work/log")"
cp "$root/tests/embed/c/app.c" "$system/tmp"
"$tool" make bone --triangles 20000 -o "$system/tmp/bone.stl" > "$work/log"
cat > "$system/tmp/use.sh" <<'USE'
set -eu
cd /tmp
lamella slice bone.stl --layer-height 0.2 --hash | sed -n 's/^hash *//p'
python3 -c 'import lamella; print(lamella.slice("bone.stl", layer_height=0.2).hash)'
cc app.c -o app $(pkg-config --cflags --libs lamella_c)
./app bone.stl > /dev/null
USE
hash=$("$tool" slice "$system/tmp/bone.stl" --layer-height 0.2 --hash | sed -n 's/^hash *//p')
[[ ${#hash} == 16 && $(chroot "$system" sh /tmp/use.sh) == "$hash"$'\n'"$hash" ]] || stop "the tool or the Python package cuts something else than $hash"
echo "installed in a clean Debian, the tool and the Python package cut the same: $hash"
