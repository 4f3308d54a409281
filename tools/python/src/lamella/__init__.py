"""Cut triangle meshes by thousands of parallel planes, straight to numpy arrays.

>>> import lamella
>>> import numpy as np
>>> corners = np.array([[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 40]], dtype=float)
>>> faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
>>> s = lamella.slice(corners, faces, layer_height=10)
>>> s
<lamella.Result: 4 layers from z 5 to 35 mm, 4 contours, 12 points>
>>> s.areas.round(3)
array([344.531, 175.781,  63.281,   7.031])

What to call
------------
slice
    One mesh, all planes, everything in memory: a `Result`.
prepare
    The same mesh many times: at other heights, by other rules.
stream
    More layers, or a larger file, than fit in memory: chunks of layers, one after the other.
slice_parts
    Several meshes at the same planes.
adaptive_layers
    Bottoms and tops of layers as high as the surface allows.
section, section_multiplane, sections
    Planes of any direction, by origin and normal: one, parallel ones, many.
sections_along, length_axis
    Planes square to a curve or an axis, at fractions of its length.
check, weld
    What is wrong with a mesh and where; cracks joined.
read
    A mesh file as a `Mesh`: STL, OBJ, OFF, PLY, VTK, VTP, 3MF, glTF, GIfTI, FreeSurfer, gzip of any.
combine
    Layers with layers: unions, differences, intersections of whole stacks, and regions by label.
offset
    Edges of layers moved in one step or several: walls, openings, lines with a width.
clip
    Polylines, as infill, cut to what lies inside layers or outside.
tracks
    Islands from layer to layer: where they begin, merge, split and end, and what they enclose.
compare
    How alike two results are: Dice, Jaccard, distances of contours.
assemble, region_of
    Contours from segments, or regions from contours, of another program.
mask, save_mask, save_structure_set
    Voxels of an image that lie inside of meshes; contours as radiotherapy reads them.
save_table, save_picture, save_archive, open
    Measures of layers, a contact sheet, whole results as HDF5 and back.
image, list_series
    Where an image's voxels lie; the series of a DICOM folder.
lamella.dask.slice_many
    Many files on the workers of a Dask scheduler; a module to import by itself.

Meshes
------
Wherever a mesh is asked for, any of these will do, and arrays are not copied:

- vertices (n, 3) and faces (m, 3), as two arguments
- triangles (m, 3, 3) or (m, 9), three corners each
- the path of a mesh file
- a `Mesh`, or a mesh of trimesh (``.vertices``, ``.faces``), meshio (``.points``, ``.cells``) or pyvista (``.points``,
  ``.faces`` that lead each face with its number of corners)

Coordinates are in mm unless `unit` says otherwise. Faces run counter-clockwise as seen from outside.
"""

from ._combine import clip, combine, offset
from ._compare import Comparison, compare
from ._errors import (  # fmt: skip
    CancelledError, CoordinateError, EmptyMeshError, Error, InvalidArgumentError, MalformedMeshError, MeshTypeError,
    MeshWarning, OutOfMemoryError, PlanesError, ResultTooLargeError, UnreadableFileError, UnwritableFileError,
)
from ._image import Image, Series, image, list_series
from ._layer import NO_TRIANGLE, SEVERAL_PARTS, ContourFlag, Layer, Polygon, Role
from ._layer_set import LayerSet
from ._medical import Mask, mask, open, save_archive, save_mask, save_picture, save_structure_set, save_table
from ._mesh import Check, Finding, Mesh, check, read, weld
from ._native import version as __version__
from ._result import Certificate, Result
from ._sections import Axis, Sections, length_axis, sections, sections_along
from ._slice import (  # fmt: skip
    Prepared, adaptive_layers, assemble, prepare, region_of, section, section_multiplane, slice, slice_parts,
)
from ._stream import Stream, stream
from ._tracks import Tracks, tracks

__all__ = [
    "Axis", "CancelledError", "Certificate", "Check", "Comparison", "ContourFlag", "CoordinateError", "EmptyMeshError",
    "Error", "Finding", "Image", "InvalidArgumentError", "Layer", "LayerSet", "MalformedMeshError", "Mask", "Mesh",
    "MeshTypeError", "MeshWarning", "NO_TRIANGLE", "OutOfMemoryError", "PlanesError", "Polygon", "Prepared", "Result",
    "ResultTooLargeError", "Role", "SEVERAL_PARTS", "Sections", "Series", "Stream", "Tracks", "UnreadableFileError",
    "UnwritableFileError", "__version__", "adaptive_layers", "assemble", "check", "clip", "combine", "compare", "image",
    "length_axis", "list_series", "mask", "offset", "open", "prepare", "read", "region_of", "save_archive", "save_mask",
    "save_picture", "save_structure_set", "save_table", "section", "section_multiplane", "sections", "sections_along",
    "slice", "slice_parts", "stream", "tracks", "weld",
]  # fmt: skip
