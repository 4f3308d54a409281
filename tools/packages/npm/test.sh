#!/usr/bin/env bash
# npm/test.sh TOOL FOLDER: installs the package in FOLDER in an empty one, and tests it there in node and in headless Chromium.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../packages.sh"
install_missing "${page_test_packages[@]}"
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd) tool=$(realpath "$1") app=$(mktemp -d)
trap 'rm -rf "$app"' EXIT
cp "$here/test.mjs" "$2"/lamella-*.tgz "$app" && cd "$app"
npm install --offline --silent --no-audit --no-fund ./lamella-*.tgz
sed -n '/^```ts$/,/^```$/{/^```/!p}' node_modules/lamella/README.md > example.mts
"$here/../../view/node_modules/.bin/tsc" --strict --target es2022 --module nodenext example.mts
"$tool" make bone --triangles 20000 -o bone.stl > /dev/null
node test.mjs "$tool" "$here/../../view/node_modules"
