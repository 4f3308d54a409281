#!/usr/bin/env python3
"""What the lab's calls take beside slicing: lab.py MESH... prints a table of ratios of processor time, medians of interleaved runs.

    measures    moments, and with diameters too, of all layers over the slice that they are of
    sections    200 planes along an axis that leans, over 200 parallel ones of the prepared mesh
    mask        of half a millimetre a voxel, over slicing and drawing alone
    stream      of the file within a tenth of its size or 40 MB, over slicing the file
"""

import os
import statistics
import sys
import time
import warnings

import lamella
import numpy as np
from lamella import _image, _native, _options

RUNS = 9


def ratios(*calls):
    """Processor time of each call over that of the first."""
    spent = [[] for _ in calls]
    for _ in range(RUNS):
        for call, times in zip(calls, spent):
            begin = time.process_time()
            call()
            times.append(time.process_time() - begin)
    first, *others = map(statistics.median, spent)
    return [f"{other / first:.2f}" for other in others]


def row(path):
    mesh, prepared = lamella.read(path), lamella.prepare(path)
    low, high = mesh.bounds
    middle = (low + high) / 2
    s = lamella.slice(mesh, layer_height=0.2)
    measures = ratios(
        lambda: lamella.slice(mesh, layer_height=0.2),
        lambda: _native.measures(s._native, False, False),
        lambda: _native.measures(s._native, False, True),
    )
    heights = low[2] + (high[2] - low[2]) * (np.arange(200) + 0.5) / 200
    places = np.column_stack((np.full(200, middle[0]), np.full(200, middle[1]), heights))
    normals = np.column_stack((0.3 * np.sin(heights), 0.3 * np.cos(heights), np.ones(200)))
    sections = ratios(lambda: prepared.slice(heights), lambda: lamella.sections(mesh, places, normals))
    image = _image.around(low, high, 0.5)
    out = np.empty(image.shape, np.uint8, order="F")
    call = _options.slice_options({}, _options.CallKeywords)

    def draw():
        cut = lamella.slice(mesh, transform=image._native.slicing_frame(False), heights=image._native.slice_heights(1))
        _native.draw_mask([(cut._native, b"a", _native.Terms())], image._native, out, False, 1, 0, call)

    mask = ratios(draw, lambda: lamella.mask(mesh, like=image, frame="lps", out=out))
    budget = max(os.path.getsize(path) // 10, 40_000_000)
    stream = ratios(lambda: lamella.slice(path, layer_height=0.2), lambda: list(lamella.stream(path, memory=budget, layer_height=0.2)))
    return [os.path.basename(path), f"{len(mesh):,}", *measures, *sections, *mask, *stream]


def main():
    warnings.simplefilter("ignore", lamella.MeshWarning)
    print("| mesh | triangles | moments | and diameters | sections | mask | stream |")
    print("|---|---|---|---|---|---|---|")
    for path in sys.argv[1:]:
        print("| " + " | ".join(row(path)) + " |", flush=True)


if __name__ == "__main__":
    main()
