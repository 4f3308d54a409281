#!/usr/bin/env bash
# install.sh PYTHON FOLDER: installs the package into a new virtual environment in FOLDER, as README says, and uses it.
set -euo pipefail
python=$1 folder=$2
source_folder=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

rm -rf "$folder"
"$python" -m venv --system-site-packages "$folder"
# A copy: setuptools leaves its files in the source folder. Version and options are read from the engine's.
mkdir -p "$folder/source/tools" "$folder/source/include" "$folder/source/engine"
cp -r "$source_folder" "$folder/source/tools/python"
cp -r "$source_folder/../../include/lamella" "$folder/source/include"
cp -r "$source_folder/../../engine/options" "$folder/source/engine"
"$folder/bin/pip" install --quiet --disable-pip-version-check --no-index --no-build-isolation --no-deps "$folder/source/tools/python"

cd /
"$folder/bin/python" - "$folder" <<'PROGRAM'
import importlib.metadata
import sys

import lamella
import numpy as np

assert lamella.__file__.startswith(sys.argv[1]), lamella.__file__
assert importlib.metadata.version("lamella") == lamella.__version__
corners = np.array([[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 40]], dtype=float)
faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
assert abs(lamella.slice(corners, faces, layer_height=1).certificate.mesh_volume - 6000) < 1e-3
PROGRAM
# The tool came along, on the path of the environment and as a module.
version=$("$folder/bin/lamella" --version)
[[ "$version" == "$("$folder/bin/python" -m lamella --version)" && -n "$version" ]]
echo "installed and used"
