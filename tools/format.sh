#!/usr/bin/env bash
# Formats the C++ and C sources that differ from the last commit; with --all, every one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh
install_missing clang-format

changed() { git diff --name-only --diff-filter=d HEAD && git ls-files --others --exclude-standard; }
every() { git ls-files; }

case "${1:-}" in
    "") sources=changed ;;
    --all) sources=every ;;
    *) stop "usage: tools/format.sh [--all]" ;;
esac
# Only what the format check looks at.
$sources | { grep -E '^(engine|include|tests|bench|tools)/.*\.[ch]pp$' || true; } | xargs --no-run-if-empty clang-format -i
