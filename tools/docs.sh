#!/usr/bin/env bash
# Builds the documentation to build/docs/html by Doxygen; any warning is an error. Its pages are in tools/docs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

install_missing doxygen
mkdir -p build
doxygen tools/docs/Doxyfile
echo "build/docs/html/index.html"
