#!/usr/bin/env bash
# deb/test.sh FOLDER: installs the packages there in a clean Debian, and uses each.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
source "$root/tools/packages.sh"
folder=$(realpath "$1")
readonly root folder system=$folder/test-deb
install_missing "${deb_packages[@]}"

rm -rf "$system"
mmdebstrap --variant=apt --include="gcc libc6-dev pkg-config" --customize-hook="cp '$folder'/*.deb \"\$1/tmp\"" \
    --customize-hook='chroot "$1" sh -c "apt-get install -y --no-install-recommends /tmp/*.deb"' \
    bookworm "$system" > "$folder/test-deb.log" 2>&1 ||
    stop "see $folder/test-deb.log"
cp "$root/tests/embed/c/app.c" "$system/tmp"
cat > "$system/tmp/use.sh" <<'USE'
set -eu
cd /tmp
lamella make bone --triangles 20000 -o bone.stl > words
lamella slice bone.stl --layer-height 0.2 --hash | sed -n 's/^hash *//p'
python3 -c 'import lamella; print(lamella.slice("bone.stl", layer_height=0.2).hash)'
cc app.c -o app $(pkg-config --cflags --libs lamella_c)
./app bone.stl > /dev/null
USE
chroot "$system" sh /tmp/use.sh
