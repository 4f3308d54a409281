#!/usr/bin/env bash
# deb/build.sh FOLDER: makes Debian packages there, of what is committed, and reads them by lintian.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
source "$root/tools/packages.sh"
folder=$(realpath "$1")
version=$(lamella_version "$root")
readonly root folder version work=$folder/deb
install_missing "${build_packages[@]}" "${deb_packages[@]}"

rm -rf "$work"
mkdir -p "$work"
git -C "$root" archive --prefix=lamella/ HEAD | tar -x -C "$work"
cd "$work/lamella"
cp -r tools/packages/debian debian
for file in debian/*@INTERFACE@* debian/control; do
    sed -i "s/@INTERFACE@/${version%.*}/" "$file"
    [[ $file != *@* ]] || mv "$file" "${file/@INTERFACE@/${version%.*}}"
done
printf 'lamella (%s) unstable; urgency=medium\n\n  * tools/docs/changes.md of the sources says what is new.\n\n -- %s  %s\n' \
    "$version" "$(sed -n 's/^Maintainer: //p' debian/control)" "$(git -C "$root" log -1 --format=%cD)" > debian/changelog
page=$root/build/view/view.html  # of `lamella view`, where it was made
LAMELLA_CMAKE_ARGS="$([[ ! -e $page ]] || echo "-DLAMELLA_VIEW_PAGE=$page") ${CMAKE_ARGS:-}" DEB_BUILD_OPTIONS="noautodbgsym ${DEB_BUILD_OPTIONS:-}" \
    dpkg-buildpackage -b -us -uc > "$work/log" 2>&1 || stop "see $work/log"
lintian --fail-on error "$work"/*.changes > "$work/lintian.log" || stop "see $work/lintian.log"
mv "$work"/*.deb "$folder"
