#!/usr/bin/env bash
# tools/view/test.sh TOOL FOLDER [times | PICTURE.png]: builds the page in FOLDER and tests it against the tool in headless Chromium,
# or prints how long it takes. PICTURE: the page, as README shows it. Exit status 77: this machine cannot test it, and why.
set -euo pipefail
tool=$(realpath "$1") folder=$(realpath -m "$2")
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
readonly tool folder here test=${3:-}
skip() {
    echo "not tested: $*"
    exit 77
}
for program in emcc npm node chromium; do
    command -v "$program" > /dev/null || skip "$program is missing (page_packages in tools/packages.sh)"
done
[[ -e $here/node_modules/.package-lock.json ]] || (cd "$here" && npm ci --no-audit --no-fund --silent --ignore-scripts > /dev/null 2>&1) ||
    skip "npm cannot get the packages of $here/package-lock.json"
"$here/build.sh" "$folder"
share=$(dirname "$(dirname "$tool")")/share/lamella
mkdir -p "$share" "$folder/test"
cp "$folder/view.html" "$share"  # where the tool looks for it
for part in page times; do
    "$here/node_modules/.bin/esbuild" "$here/test/$part.ts" --bundle --platform=node --format=esm --packages=external --log-level=warning \
        --outfile="$folder/test/$part.mjs"
done
ln -sfn "$here/node_modules" "$folder/test/node_modules"
if [[ $test == times ]]; then
    node "$folder/test/times.mjs" "$folder/view.html" "$tool" "$folder/test"
else
    node "$folder/test/page.mjs" "$folder/view.html" "$tool" "$folder/test" ${3:+"$3"}
fi
