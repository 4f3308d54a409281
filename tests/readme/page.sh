#!/usr/bin/env bash
# page.sh PAGE TOOL FILE...: runs the page's blocks in bash in an empty folder, and checks that they make the files. Sourced by
# scripts that check more of a page: what it prints is in `output`, and a function `prepare` is called before.
set -euo pipefail
page=$(realpath "$1")
tool=$(realpath "$2")
shift 2

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
! declare -F prepare > /dev/null || prepare
sed -n '/^```bash$/,/^```$/p' "$page" | sed '/^```/d' > examples
PATH=$(dirname "$tool"):$PATH bash -eu examples > output
for made in "$@"; do
    [[ -s "$made" ]] || { echo "no $made was written"; exit 1; }
done
