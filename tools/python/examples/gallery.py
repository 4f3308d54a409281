"""Draws the pictures of the page "Gallery", by the functions that it shows.

    lamella make bone --triangles 400000 -o bone.stl
    python gallery.py bone.stl FOLDER
"""

import pathlib
import re
import sys

import lamella
import matplotlib.pyplot as plt
import numpy as np

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/gallery.md"


def main(path, folder):
    """The names of the pictures."""
    mesh = lamella.read(path)
    drawn = []
    for function in re.findall(r"^```py\n(.*?)^```$", PAGE.read_text(), flags=re.MULTILINE | re.DOTALL):
        names = {"lamella": lamella, "np": np}
        exec(function, names)
        name, draw = names.popitem()
        figure, axes = plt.subplots(figsize=(4, 3), dpi=100, layout="constrained")
        draw(mesh, axes)
        drawn.append(f"python_{name}.png")
        figure.savefig(pathlib.Path(folder) / drawn[-1])
        plt.close(figure)
    return drawn


if __name__ == "__main__":
    main(*sys.argv[1:])
