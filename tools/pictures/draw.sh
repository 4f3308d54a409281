#!/usr/bin/env bash
# Draws the picture in README.md: a bone of four million triangles, cut once along its length.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
tools/demo.sh 4000000
cp build/demo/cut.png tools/pictures/bone.png
