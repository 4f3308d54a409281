"""Cuts a binary STL file from Python, by ctypes and nothing else.

    app.py LIBRARY SAMPLE
"""

import ctypes
import sys
from ctypes import POINTER, Structure, byref, c_double, c_int32, c_int64, c_size_t, c_uint8, c_uint16, c_uint32, c_uint64, c_void_p


STOP = ctypes.CFUNCTYPE(c_int32, c_void_p)
# The kinds of structs that lamella_init_sized() knows.
KINDS = {"Error": 0, "Context": 1, "Mesh": 2, "Source": 3, "Options": 4, "Sink": 8, "Destination": 10}


class Mesh(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("vertex_type", c_int32), ("vertices", c_void_p), ("vertex_count", c_size_t),
        ("triangle_count", c_size_t), ("indices", c_void_p), ("vertex_stride", c_size_t), ("index_stride", c_size_t),
        ("mm_per_unit", c_double), ("index_type", c_int32), ("reserved", c_int32),
    ]  # fmt: skip


class Source(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("reserved", c_int32), ("mesh", POINTER(Mesh)), ("prepared", c_void_p), ("parts", c_void_p),
        ("part_count", c_size_t),
    ]  # fmt: skip


class Options(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("reserved", c_int32), ("layer_height_mm", c_double), ("heights_mm", POINTER(c_double)),
        ("height_count", c_size_t), ("stitch_mm", c_double), ("first_height_mm", c_double), ("first_layer", c_uint64),
        ("end_layer", c_uint64), ("transform", c_double * 12), ("grid_mm", c_double), ("closing_mm", c_double),
        ("offset_mm", c_double), ("miter_limit", c_double), ("simplify_mm", c_double), ("flag_closing_mm", c_double),
        ("fill_from", c_void_p), ("fill_from_count", c_size_t), ("at_heights", c_int32), ("stitch_direction", c_int32),
        ("origins", c_int32), ("unite_parts", c_int32), ("allow_empty", c_int32), ("content", c_int32), ("datum", c_int32),
        ("side", c_int32), ("coarser_if_needed", c_int32), ("as_mesh_numbers", c_int32), ("fill_rule", c_int32),
        ("drop_collinear", c_int32), ("largest_only", c_int32), ("reserved_0_3", c_int32),
    ]  # fmt: skip


class Error(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("status", c_int32), ("part", c_int64), ("triangle", c_int64), ("plane", c_int64),
        ("byte_offset", c_int64), ("message", ctypes.c_char * 512),
    ]  # fmt: skip


class PointOrigin(Structure):
    _fields_ = [("triangle", c_uint32), ("part", c_uint16), ("edge", c_uint8), ("end_edge", c_uint8)]


class Layer(Structure):
    _fields_ = [
        ("bottom_mm", c_double), ("plane_mm", c_double), ("top_mm", c_double), ("first_contour", c_uint64),
        ("contour_count", c_uint64), ("segments", c_uint64), ("plane", c_int32), ("reserved", c_int32),
    ]  # fmt: skip


class LayerView(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("reserved", c_int32), ("index", c_uint64), ("grid_mm", c_double), ("layer", Layer),
        ("contours", c_void_p), ("points", POINTER(c_int32)), ("point_count", c_uint64), ("first_point", c_uint64),
        ("origins", POINTER(PointOrigin)), ("stitches", c_void_p), ("stitch_count", c_uint64),
    ]  # fmt: skip


class Context(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("threads", c_int32), ("stop", STOP), ("stop_object", c_void_p), ("progress", c_void_p),
        ("progress_object", c_void_p), ("memory", c_void_p), ("memory_limit_bytes", c_uint64), ("executor", c_void_p),
        ("executor_object", c_void_p), ("executor_threads", c_int32), ("reserved", c_int32),
    ]  # fmt: skip


TAKE = ctypes.CFUNCTYPE(None, c_void_p, POINTER(LayerView))


class Sink(Structure):
    _fields_ = [("struct_size", c_uint32), ("order", c_int32), ("take", TAKE), ("begin", c_void_p), ("object", c_void_p)]


class Destination(Structure):
    _fields_ = [
        ("struct_size", c_uint32), ("reserved", c_int32), ("result", c_void_p), ("sink", POINTER(Sink)), ("arrays", c_void_p),
    ]  # fmt: skip


def made(lamella, kind):
    """A struct with its defaults."""
    struct = kind()
    lamella.lamella_init_sized(byref(struct), KINDS[kind.__name__], c_size_t(ctypes.sizeof(struct)))
    return struct


def slice_to(lamella, take, mesh, options, context, error):
    source, sink, to = made(lamella, Source), made(lamella, Sink), made(lamella, Destination)
    source.mesh = ctypes.pointer(mesh)
    sink.take = TAKE(take)
    to.sink = ctypes.pointer(sink)
    return lamella.lamella_slice_to(None, byref(to), byref(source), byref(options), context, None, byref(error))


class Kept:
    """The first exception of a call's callbacks. `stop` is lamella_context.stop; finish() follows the call."""

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
    kept, context, layers = Kept(), made(lamella, Context), []
    context.stop = kept.stop

    def take(_, view):
        layers.append(view.contents.index)
        raise LookupError("enough")

    status = slice_to(lamella, kept.keeping(take), mesh, options, byref(context), error)
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
    mesh, options, error = made(lamella, Mesh), made(lamella, Options), made(lamella, Error)
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
        contours.append(layer.layer.contour_count)
        named.extend(layer.origins[i].triangle for i in range(layer.point_count))

    if slice_to(lamella, take, mesh, options, None, error) != 0:
        sys.exit(error.message.decode())
    if not named or max(named) >= mesh.triangle_count:
        sys.exit("edges come from triangles that the mesh does not have")
    raise_in_a_sink(lamella, mesh, options, error)
    mesh.triangle_count = 0
    if slice_to(lamella, take, mesh, options, None, error) != 4:
        sys.exit("a mesh without triangles is not refused")
    print(f"{len(contours)} layers, {sum(contours)} contours")


if __name__ == "__main__":
    main()
