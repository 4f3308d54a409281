#!/usr/bin/env python3
"""Measures the peak memory of slicing, one process for each mesh. Usage: peaks.py PROGRAM OUT.json NAME=MESH..."""
import json
import subprocess
import sys

LAYER_HEIGHT_MM = "0.032"
BAND_PLANES = (0, 16, 1)


def main():
    program, out, meshes = sys.argv[1], sys.argv[2], sys.argv[3:]
    peaks = []
    for name, mesh in (each.split("=", 1) for each in meshes):
        for band_planes in BAND_PLANES:
            made = subprocess.run([program, mesh, LAYER_HEIGHT_MM, "2", str(band_planes)], check=True, capture_output=True)
            peaks.append({"name": name} | json.loads(made.stdout) | {"mesh": mesh.rsplit("/", 1)[-1]})
    with open(out, "w", encoding="utf-8") as file:
        json.dump(peaks, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main()
