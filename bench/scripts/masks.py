#!/usr/bin/env python3
"""Times label masks of 512 x 512 x 275 voxels of one mesh, its contours being there.

    bench/scripts/masks.py BUILD MESH.stl [--readme bench/README.md] [--rounds 15]

Runs BUILD/bench/lamella_masks with 1 and 2 threads and prints a table; with --readme it also replaces the one between the
markers there. The bar holds for 2 threads that have a core each: where others use the machine, wall times say little, and
`of processor time` is what 2 free cores would give if all work ran on both. The exit status is 1 if the raster alone does not
meet its bar by either.
"""

import sys
import tempfile

from readme_table import Bars, compare, markdown_table, output_of

BAR = 1.0  # G voxels/s of the raster, 2 threads
VOXELS = 512 * 512 * 275
WAYS = {"raster": "contours to voxels in memory", "nii": "`write_mask()`, .nii", "nrrd": "`write_mask()`, .nrrd (gzip)"}


def tables(arguments, bars):
    with tempfile.TemporaryDirectory() as folder:
        reports = [output_of(arguments.build / "bench" / "lamella_masks", arguments.mesh, str(threads), folder, str(arguments.rounds))
                   for threads in (1, 2)]
    heads = ["way", "threads", "wall time, median (least)", "processor time", "G voxels/s, median", "of processor time"]
    rows, bars.met = [], False
    for way, words in WAYS.items():
        for report in reports:
            threads, times = report["threads"], report[way]
            by_wall, by_work = times["voxels_per_s"] / 1e9, VOXELS * threads / times["processor_ms"] / 1e6
            bar = BAR if way == "raster" and threads == 2 else None
            rows.append([words, threads, f"{times['wall_ms']:.0f} ms ({times['least_wall_ms']:.0f})",
                         f"{times['processor_ms']:.0f} ms", f"{by_wall:.2f}", Bars().least(f"{by_work:.2f}", by_work, bar)])
            bars.met = bars.met or (bar is not None and max(by_wall, by_work) >= bar)
    sizes = f"{reports[0]['triangles']:,} triangles, {reports[0]['points']:,} points, 512 x 512 x 275 voxels:"
    return [sizes, markdown_table(heads, rows)]


if __name__ == "__main__":
    sys.exit(compare(__doc__, "masks", tables, "build", "mesh", rounds=15))
