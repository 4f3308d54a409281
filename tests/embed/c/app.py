"""Cuts a binary STL file from Python, by ctypes and nothing else.

    app.py LIBRARY SAMPLE
"""

import ctypes
import sys
from ctypes import POINTER, Structure, byref, c_double, c_int32, c_int64, c_size_t, c_uint8, c_uint16, c_uint32, c_uint64, c_void_p


STOP = ctypes.CFUNCTYPE(c_int32, c_void_p)


class Mesh(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("coordinate_type", c_int32), ("vertices", c_void_p), ("vertex_stride", c_size_t),
        ("vertex_count", c_size_t), ("indices", c_void_p), ("index_stride", c_size_t), ("index_type", c_int32),
        ("reserved", c_int32), ("triangle_count", c_size_t), ("coordinate_mm", c_double),
    ]  # fmt: skip


class Options(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("spacing", c_int32), ("layer_height_mm", c_double), ("first_height_mm", c_double),
        ("datum", c_int32), ("side", c_int32), ("heights_mm", POINTER(c_double)), ("height_count", c_size_t),
        ("unit_mm", c_double), ("transform", c_double * 12), ("arithmetic", c_int32), ("unit_fit", c_int32),
        ("region", c_void_p), ("close_gaps_mm", c_double), ("gap_sense", c_int32), ("allow_empty", c_int32),
        ("memory_limit_bytes", c_uint64), ("control", c_void_p), ("origins", c_int32), ("reserved", c_int32),
    ]  # fmt: skip


class Error(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("status", c_int32), ("triangle", c_int64), ("plane", c_int64), ("byte_offset", c_int64),
        ("message", ctypes.c_char * 512),
    ]  # fmt: skip


class PointOrigin(Structure):
    _fields_ = [("triangle", c_uint32), ("part", c_uint16), ("edge", c_uint8), ("end_edge", c_uint8)]


class LayerView(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("reserved", c_int32), ("index", c_uint64), ("unit_mm", c_double), ("layer", c_void_p),
        ("contours", c_void_p), ("contour_count", c_uint64), ("points", POINTER(c_int32)), ("point_count", c_uint64),
        ("closed_gaps", c_void_p), ("closed_gap_count", c_uint64), ("origins", POINTER(PointOrigin)),
    ]  # fmt: skip


class Control(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("threads", c_int32), ("executor", c_void_p), ("executor_context", c_void_p),
        ("executor_threads", c_int32), ("reserved", c_int32), ("memory", c_void_p), ("stop", STOP), ("stop_context", c_void_p),
        ("progress", c_void_p), ("progress_context", c_void_p),
    ]  # fmt: skip


TAKE = ctypes.CFUNCTYPE(None, c_void_p, POINTER(LayerView))


class Sink(Structure):
    _fields_ = [("take", TAKE), ("context", c_void_p), ("order", c_int32), ("reserved", c_int32)]


class Kept:
    """The first exception of a call's callbacks. `stop` is lamella_control.stop; finish() follows the call."""

    def __init__(self):
        self.first = None
        self.stop = STOP(lambda _: self.first is not None)

    def keeping(self, callback):
        def guarded(*arguments):
            try:
                callback(*arguments)
            except BaseException as raised:
                self.first = self.first or raised

        return guarded

    def finish(self):
        if self.first is not None:
            raise self.first


def raise_in_a_sink(lamella, mesh, options, error):
    """The exception ends the call at that layer and comes back."""
    kept, control, layers = Kept(), Control(), []
    lamella.lamella_control_init_sized(byref(control), c_size_t(ctypes.sizeof(control)))
    control.stop = kept.stop
    options.control = ctypes.addressof(control)

    def take(_, view):
        layers.append(view.contents.index)
        raise LookupError("enough")

    sink = Sink(TAKE(kept.keeping(take)), None, 1, 0)
    status = lamella.lamella_slice_to(byref(sink), byref(mesh), byref(options), None, None, byref(error))
    options.control = None
    try:
        kept.finish()
    except LookupError:
        if status == 9 and layers == [0]:
            return
    sys.exit(f"an exception of a sink gave status {status} after {len(layers)} layers")


def main():
    lamella = ctypes.CDLL(sys.argv[1])
    with open(sys.argv[2], "rb") as file:
        stl = file.read()
    mesh, options, error = Mesh(), Options(), Error()
    for name, struct in (("mesh", mesh), ("options", options), ("error", error)):
        getattr(lamella, f"lamella_{name}_init_sized")(byref(struct), c_size_t(ctypes.sizeof(struct)))
    body = ctypes.create_string_buffer(stl[84 + 12 :])
    mesh.vertices = ctypes.addressof(body)
    mesh.vertex_stride = 50
    mesh.triangle_count = int.from_bytes(stl[80:84], "little")
    options.layer_height_mm = 0.5
    options.origins = 1
    contours = []
    named = []

    def take(_, view):
        layer = view.contents
        contours.append(layer.contour_count)
        named.extend(layer.origins[i].triangle for i in range(layer.point_count))

    sink = Sink(TAKE(take), None, 1, 0)
    if lamella.lamella_slice_to(byref(sink), byref(mesh), byref(options), None, None, byref(error)) != 0:
        sys.exit(error.message.decode())
    if not named or max(named) >= mesh.triangle_count:
        sys.exit("edges come from triangles that the mesh does not have")
    raise_in_a_sink(lamella, mesh, options, error)
    mesh.triangle_count = 0
    if lamella.lamella_slice_to(byref(sink), byref(mesh), byref(options), None, None, byref(error)) != 4:
        sys.exit("a mesh without triangles is not refused")
    print(f"{len(contours)} layers, {sum(contours)} contours")


if __name__ == "__main__":
    main()
