"""All layers of a mesh, as arrays."""

from __future__ import annotations

import functools
import itertools
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Optional, Tuple, Union, overload

import numpy as np
import numpy.typing as npt

from . import _conversions, _native
from ._errors import Error, InvalidArgumentError, MeshWarning, warn
from ._layer import NO_TRIANGLE, Layer, Role
from ._layer_set import SetMethods

if TYPE_CHECKING:
    import pandas

    from ._mesh import View


@dataclass(frozen=True)
class Certificate:
    """Tells whether areas and volumes of a result are those of the mesh, by another computation than slicing."""

    verdict: str
    """"holds", "areas differ", "volumes differ", or why it does not apply: "open mesh", "contours not as walked", "solid is
    not what the mesh encloses"."""
    mesh_volume: float
    """Signed volume of the mesh, mm³; NaN of an open one."""
    slab_volumes: npt.NDArray[np.float64]
    """Volume between neighbouring planes, mm³; the first and last below and above all planes."""
    worst_layer: int
    """Where the areas of mesh and contours differ most, as a share of what rounding allows."""
    worst_difference: float
    """By so many mm²."""
    worst_allowed: float
    """They may differ by so many mm²."""
    differing_layers: int = 0
    """Layers in which what is solid is not what the mesh encloses, as shells overlap or are turned inwards."""
    differing_signed: float = 0
    """In those, what the mesh encloses by its facets, mm²."""
    differing_solid: float = 0
    """In those, what is solid, mm²."""

    @property
    def holds(self) -> bool:
        """The areas of all layers and the volumes between them are those of the mesh."""
        return self.verdict == "holds"


class Result(SetMethods):
    """Layers, contours and points of a sliced mesh.

    Three flat arrays, views of the engine's memory, which are read-only and live as long as any of them does::

        layers    [ L0 | L1 | L2 | ... ]              one per plane, ascending
                    |    `------.
        contours  [ outer, hole | outer | ... ]       per layer, each outer followed by its holes
                    |      `--------.
        points    [ x y, x y, x y | x y, x y, ... ]   per contour, solid on the left; the first is not repeated

    ``len()``, iteration and indexing give `Layer` objects, which are made when they are asked for. A result keeps its mesh,
    for the certificate and the report.

    Attributes
    ----------
    first_layer : int
        Of a chunk of `stream`, or of some ``layers``: the number of layers of the plan before it. Else 0.

    Examples
    --------
    >>> s = lamella.slice(corners, faces, layer_height=10)
    >>> s.points[:3].round(3)
    array([[ 0.  ,  0.  ],
           [26.25,  0.  ],
           [ 0.  , 26.25]])
    >>> s[-1].z
    35.0
    >>> [round(layer.area, 3) for layer in s if layer.z < 10]
    [344.531]
    """

    def __init__(self, native: _native.Result, view: Optional[View]) -> None:
        self._native = native
        self._view = view
        self.first_layer: int = native.first_layer

    @functools.cached_property
    def layers(self) -> npt.NDArray[np.void]:
        """One row per plane, ascending: a structured array.

        ``bottom``, ``z``, ``top`` in mm, ``first_contour``, ``contour_count``, ``segments`` (triangles that the plane
        crosses) and ``z_grid``, the height that was cut, in grid units.
        """
        return self._native.layers

    @functools.cached_property
    def contours(self) -> npt.NDArray[np.void]:
        """One row per contour: a structured array.

        ``first_point``, ``point_count``, ``role`` (`Role`), ``parent`` (row of the closed contour around it, or -1),
        ``segments``, ``orientation`` by the facets, ``flags`` (`ContourFlag`), ``part``, and ``twice_area_low`` and
        ``twice_area_high``, the exact area as a 128-bit integer of half square grid units; in mm² see `contour_areas`.
        """
        return self._native.contours

    @functools.cached_property
    def points_grid(self) -> npt.NDArray[np.int32]:
        """Points (n, 2) of all contours, in grid units. Times `grid` they are mm."""
        return self._native.points_grid

    @functools.cached_property
    def points(self) -> npt.NDArray[np.float64]:
        """Points (n, 2) of all contours, mm. Converted once, when first asked for."""
        points = self.points_grid * self.grid
        points.setflags(write=False)
        return points

    @functools.cached_property
    def origins(self) -> npt.NDArray[np.void]:
        """Where each point and the contour edge that begins there come from; empty unless ``origins=True``.

        ``triangle`` (`NO_TRIANGLE` if none), ``part``, and ``edge`` and ``end_edge``, the edges of that triangle on which
        the contour edge begins and ends: edge e leads from corner e to corner (e + 1) % 3, and 3 is none.
        """
        return self._native.origins

    @functools.cached_property
    def stitches(self) -> npt.NDArray[np.void]:
        """Ends of open polylines that were joined: ``layer``, ``from_grid`` and ``to_grid``."""
        return self._native.stitches

    @functools.cached_property
    def layer_of(self) -> npt.NDArray[np.int64]:
        """The layer of each of the `heights` that were given; empty for uniform layers."""
        return self._native.layer_of

    @functools.cached_property
    def copies(self) -> npt.NDArray[np.void]:
        """With ``share_copies=True`` the parts that are not among the contours: `part`, `first`, the part whose contours they
        have, and `move_grid`, by how much these are moved.
        """
        return self._native.copies

    @functools.cached_property
    def areas(self) -> npt.NDArray[np.float64]:
        """Solid area of each layer, mm²: outers minus holes. NaN, not known, where the layer has open contours."""
        return self._native.areas()

    @functools.cached_property
    def perimeters(self) -> npt.NDArray[np.float64]:
        """Length of the contours of each layer, mm. NaN, not known, where some are open."""
        lengths = np.where(self.contours["role"] == Role.OPEN, np.nan, self.contour_lengths)
        return np.bincount(self._layer_of_contours, lengths, len(self)).astype(np.float64)

    @functools.cached_property
    def contour_areas(self) -> npt.NDArray[np.float64]:
        """Area within each contour, mm²: negative for holes, 0 for flat and open ones."""
        return self._native.contour_areas()

    @functools.cached_property
    def contour_lengths(self) -> npt.NDArray[np.float64]:
        """Length of each contour, mm."""
        return self._native.contour_lengths()

    @functools.cached_property
    def measures(self) -> npt.NDArray[np.void]:
        """One row per layer: a structured array of what papers print, mm, mm², mm⁴ and radians. Computed when first asked for.

        ``z``, ``known``, ``islands``, ``holes``, ``open``, ``area``, ``outer_area`` (with holes filled), ``perimeter``,
        ``outer_perimeter``, ``centroid_x``, ``centroid_y``; about the centroid ``ix``, ``iy``, ``ixy``, ``imin``, ``imax``,
        ``polar`` and ``angle`` of the long axis; ``box_min_x`` to ``box_max_y``, ``feret_max``, ``feret_min``, ``feret_angle``,
        ``equivalent_diameter`` and ``circularity``. Not known is NaN, empty is 0. Sums are exact until the last step.
        """
        return _native.measures(self._native, False, True)

    @functools.cached_property
    def island_measures(self) -> npt.NDArray[np.void]:
        """The same, one row per island: an outer with its own holes. ``layer`` and ``contour`` say which."""
        return _native.measures(self._native, True, True)

    def layers_frame(self, *, islands: bool = False) -> pandas.DataFrame:
        """`measures` as a pandas DataFrame, or `island_measures`."""
        import pandas

        measures = self.island_measures if islands else self.measures
        columns = [name for name in measures.dtype.names or () if islands or name != "contour"]
        return pandas.DataFrame({name: measures[name] for name in columns})

    def points_in_mesh(self) -> npt.NDArray[np.float64]:
        """Points (n, 3) of all contours, mm, in the frame of the mesh."""
        inverse = np.linalg.inv(self.frame)
        z = np.repeat(self.layers["z"][self._layer_of_contours], self.contours["point_count"])
        placed: npt.NDArray[np.float64] = np.column_stack((self.points, z)) @ inverse[:3, :3].T + inverse[:3, 3]
        return placed

    def scalars(self, values: Union[str, npt.ArrayLike]) -> npt.NDArray[np.float64]:
        """Values at the mesh's vertices carried to contour points: linear within each triangle. Needs ``origins=True``.

        Parameters
        ----------
        values : str, or array_like of shape (vertices,) or (vertices, k)
            A name of `Mesh.scalars`, or a row for each of `Mesh.vertices`: curvature, thickness, colour. Integers are labels: a
            point takes that of the nearest corner of its triangle, never a mean.

        Returns
        -------
        ndarray
            A row for each of `points`. NaN where a point comes from no triangle, as of joined gaps.
        """
        view = self._whole_mesh("scalars")
        if view.of_parts:
            raise InvalidArgumentError("scalars are those of one mesh, and this is a result of parts")
        mesh = view._meshes[0]
        if isinstance(values, str) and values not in mesh.scalars:
            names = ", ".join(map(repr, mesh.scalars)) or "none: lamella.read(path, scalars=True) reads a file's"
            raise InvalidArgumentError(f"the mesh has no values {values!r}, but {names}")
        given = np.asarray(mesh.scalars[values] if isinstance(values, str) else values)
        are_labels = given.dtype.kind in "iub"
        given = given.astype(np.float64)
        if given.ndim not in (1, 2) or len(given) != len(mesh.vertices):
            raise InvalidArgumentError(f"values must have a row for each of {len(mesh.vertices):,} vertices, and have shape {given.shape}")
        if len(self.origins) != len(self.points_grid):
            raise InvalidArgumentError("scalars need origins: slice with origins=True")
        triangle = self.origins["triangle"]
        known = np.flatnonzero(triangle != NO_TRIANGLE)
        corners = mesh.faces[triangle[known]]
        a, b, c = np.moveaxis(mesh.vertices[corners].astype(np.float64) * mesh.unit, 1, 0)
        ab, ac, ap = b - a, c - a, self.points_in_mesh()[known] - a
        ab2, ac2, both = (np.einsum("ni,ni->n", u, v) for u, v in ((ab, ab), (ac, ac), (ab, ac)))
        on_ab, on_ac = (np.einsum("ni,ni->n", ap, u) for u in (ab, ac))
        size = np.maximum(ab2 * ac2 - both * both, np.finfo(float).tiny)
        second, third = (ac2 * on_ab - both * on_ac) / size, (ab2 * on_ac - both * on_ab) / size
        weights = np.clip(np.stack((1 - second - third, second, third), axis=1), 0, 1)
        weights /= weights.sum(axis=1, keepdims=True)
        carried = np.full((len(triangle), *given.shape[1:]), np.nan)
        if are_labels:
            weights = np.eye(3)[weights.argmax(axis=1)]
        carried[known] = np.einsum("nw,nw...->n...", weights, given[corners])
        return carried

    @property
    def volume(self) -> float:
        """Volume of the layers, mm³: the sum of area times thickness. NaN, not known, where a layer has open contours.

        That of the mesh: ``certificate.mesh_volume``.
        """
        return float(self.areas @ (self.layers["top"] - self.layers["bottom"]))

    @property
    def grid(self) -> float:
        """Step of the grid, mm."""
        return self._native.grid

    @functools.cached_property
    def frame(self) -> npt.NDArray[np.float64]:
        """Affine map (4, 4) from the mesh, in mm, to the space of layers and points."""
        return np.vstack((self._native.options["transform"], (0, 0, 0, 1)))

    @functools.cached_property
    def info(self) -> Dict[str, Any]:
        """Counts of triangles, segments and contours, grid, the mesh's box, and times of the stages in ms.

        ``open_layers`` of ``crossed_layers`` have open contours and stand for ``open_height_share`` of the height;
        ``stitch=closing_stitch`` would close them.
        """
        return self._native.info

    @property
    def hash(self) -> str:
        """Hash of layers, contours and points: 16 hexadecimal digits. Equal on every platform and number of threads."""
        return f"{self._native.hash():016x}"

    @functools.cached_property
    def certificate(self) -> Certificate:
        """Tells whether areas and volumes are those of the mesh. Takes about as long as slicing.

        Needs the mesh, which must be as it was when it was sliced.
        """
        view = self._whole_mesh("certificate")
        if len(view._meshes) != 1:
            raise InvalidArgumentError(f"the certificate is for one mesh, and there are {len(view._meshes)}")
        return Certificate(**view.run(lambda native: _native.certify(self._native, native)))

    @property
    def _layer_of_contours(self) -> npt.NDArray[np.int64]:
        return np.repeat(np.arange(len(self)), self.layers["contour_count"])

    def contours_frame(self) -> pandas.DataFrame:
        """One row per contour as a pandas DataFrame: layer, z, role, area, length, points, parent, part, flags, segments."""
        import pandas

        contours, layers = self.contours, self.layers
        layer = self._layer_of_contours
        measured = {
            "layer": layer + self.first_layer,
            "z": layers["z"][layer],
            "role": pandas.Categorical.from_codes(contours["role"], [role.name.lower() for role in Role]),
            "area": self.contour_areas,
            "length": self.contour_lengths,
        }
        as_it_is = ("first_point", "point_count", "parent", "part", "flags", "segments")
        return pandas.DataFrame({**measured, **{name: contours[name] for name in as_it_is}})

    def to_vtk(self) -> Any:
        """Contours as a vtkPolyData of polylines in the mesh's frame, with cell arrays ``layer``, ``role``, ``part``. Needs vtk.

        With ``origins=True`` the values of `Mesh.scalars` are its point data, for vtkXMLPolyDataWriter to write as VTP.
        """
        return _conversions.to_vtk(self)

    def to_pyvista(self) -> Any:
        """The same as a pyvista.PolyData. Needs pyvista."""
        import pyvista

        return pyvista.wrap(self.to_vtk())

    def to_trimesh(self) -> Any:
        """Contours as a trimesh.path.Path3D in the mesh's frame. Needs trimesh."""
        return _conversions.to_trimesh(self)

    def to_geopandas(self) -> Any:
        """Islands as a geopandas.GeoDataFrame: a polygon with its holes each, ``layer``, ``z`` and its measures. Needs geopandas."""
        return _conversions.to_geopandas(self)

    def plot_stack(self, ax: Any = None, *, most: int = 40, **style: Any) -> Any:
        """Draw the contours of at most `most` layers in three dimensions with matplotlib, in the mesh's frame."""
        return _conversions.plot_stack(self, ax, most, style)

    def save(self, path: Union[str, bytes, os.PathLike[Any]]) -> None:
        """Write the result to a file, which appears whole or not at all.

        Parameters
        ----------
        path : path
            Its end decides: ``.json`` for the report: counts, ledger of triangles, certificate, places of open contours; else a
            file of layers: ``.svg``, ``.cli``, ``.3mf`` (slices), ``.dxf``, ``.geojson`` or ``.vtp``. ``{layer:05}`` in the
            name stands for a file a layer, of SVG, DXF and GeoJSON.
        """
        name = os.fsdecode(path)
        try:
            if name.lower().endswith(".json"):
                _native.write_report(self._native, self._whole_mesh("report").native, os.fsencode(name))
            else:
                _native.write_layers(self._native, os.fsencode(name))
        except Error as error:
            error.path = name
            raise

    def _whole_mesh(self, what: str) -> View:
        if self._view is None:
            raise InvalidArgumentError(f"the {what} needs the whole mesh, which pickled results, chunks of layers and combined layers do not have")
        return self._view

    def __len__(self) -> int:
        return len(self._native)

    def __iter__(self) -> Iterator[Layer]:
        return map(Layer, itertools.repeat(self), range(len(self)))

    @overload
    def __getitem__(self, index: int) -> Layer: ...

    @overload
    def __getitem__(self, index: slice) -> List[Layer]: ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Layer, List[Layer]]:
        chosen = range(len(self))[index]
        return Layer(self, chosen) if isinstance(chosen, int) else [Layer(self, i) for i in chosen]

    def __repr__(self) -> str:
        z = self.layers["z"]
        count = len(z)
        where = f" from z {z[0]:g} to {z[-1]:g} mm" if count > 1 else f" at z {z[0]:g} mm" if count == 1 else ""
        return (
            f"<lamella.Result: {count:,} layer{'s' if count != 1 else ''}{where}, "
            f"{len(self.contours):,} contours, {len(self.points_grid):,} points>"
        )

    def _repr_html_(self) -> str:
        """For notebooks: a table of what there is, beside the layer of the largest area."""
        rows = {
            "layers": f"{len(self):,}",
            "contours": f"{len(self.contours):,}",
            "points": f"{len(self.points_grid):,}",
            "volume": f"{self.volume:,.6g} mm³",
        }
        picture = ""
        if len(self) > 0:
            largest = self[int(np.argmax(np.nan_to_num(self.areas)))]
            rows["z"] = f"{self[0].z:g} to {self[-1].z:g} mm"
            rows["shown"] = f"layer {largest.index}, z {largest.z:g} mm"
            picture = largest._repr_html_()
        cells = "".join(f"<tr><th>{name}</th><td>{text}</td></tr>" for name, text in rows.items())
        return f'<div style="display:flex;gap:1em;align-items:center">{picture}<table>{cells}</table></div>'

    def __reduce__(self) -> Tuple[Any, ...]:
        return (_restore, (self._native.state(), self.__dict__.get("certificate")))


def _restore(state: Tuple[Any, ...], certificate: Optional[Certificate]) -> Result:
    result = Result(_native.restore(state), None)
    if certificate is not None:
        result.__dict__["certificate"] = certificate
    return result


def finish(native: _native.Result, view: View) -> Result:
    """The result of a call, after warning of what is wrong with it."""
    warn_of_open(native.open_layers())
    cancelled = native.cancelled_layers
    if cancelled > 0:
        where = "1 layer" if cancelled == 1 else f"{cancelled:,} layers"
        text = f"in {where} shells turned inwards overlap others, and where they do, both cancel: solid is missing there"
        warn(f"{text}; orient_shells=True turns each shell outwards unless it bounds a cavity", MeshWarning)
    if (coarse := native.coarse_grid(view.native)) is not None:
        step, diagonal, finest = coarse
        help_ = f"grid='finest' takes {finest:g} mm" if finest < step else "none finer reaches the mesh's coordinates"
        warn(f"the grid of {step:g} mm is coarse for a mesh of {diagonal:g} mm from corner to corner; {help_}", MeshWarning)
    return Result(native, view)


def warn_of_open(layers: _native.OpenLayers) -> None:
    """Warns where areas are not known."""
    if layers.layers > 0:
        warn(layers.describe("stitch="), MeshWarning)
