"""Draws the pictures of the page "Gallery".

    lamella make bone --triangles 400000 -o bone.stl
    python gallery.py bone.stl FOLDER
"""

import pathlib
import sys

import lamella
import matplotlib.pyplot as plt
import numpy as np


def areas_over_height(mesh, axes):
    s = lamella.slice(mesh, layer_height=0.1)
    axes.plot(s.layers["z"], s.areas, linewidth=1)
    axes.set(xlabel="z (mm)", ylabel="area (mm²)")


def one_layer(mesh, axes):
    s = lamella.slice(mesh, layer_height=0.1)
    s[np.argmax(s.layers["contour_count"])].plot(axes)


def oblique_section(mesh, axes):
    box = lamella.slice(mesh, layer_height=1).info
    middle = (np.array(box["min"]) + box["max"]) / 2
    lamella.section(mesh, middle, normal=[1, 0.2, 0.1], stitch=0.1).plot(axes)


def places_of_faults(mesh, axes):
    corners = mesh.triangles
    damaged = np.delete(corners, np.s_[:: len(corners) // 40], axis=0)  # forty triangles are missing
    edges = lamella.check(damaged)["boundary_edges"].points[:, 0]
    axes.scatter(edges[:, 2], edges[:, 1], s=4, color="#c03020")
    outline = lamella.section(mesh, corners.reshape(-1, 3).mean(axis=0), normal=[1, 0, 0])
    for polygon in outline.polygons():
        flat = np.column_stack((polygon.outer, np.zeros(len(polygon.outer)), np.ones(len(polygon.outer))))
        at = flat @ outline.to_3d.T
        axes.fill(at[:, 2], at[:, 1], facecolor="none", edgecolor="#20435f", linewidth=0.5)
    axes.set(xlabel="z (mm)", ylabel="y (mm)", aspect="equal")


PICTURES = [areas_over_height, one_layer, oblique_section, places_of_faults]


def main(path, folder):
    mesh = lamella.read(path)
    for draw in PICTURES:
        figure, axes = plt.subplots(figsize=(4, 3), dpi=100, layout="constrained")
        draw(mesh, axes)
        figure.savefig(pathlib.Path(folder) / f"python_{draw.__name__}.png")
        plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:])
