"""Cuts a binary STL file from Python, by ctypes and the C header alone.

    app.py HEADER LIBRARY SAMPLE
"""

import ctypes
import pathlib
import re
import sys
from ctypes import byref, c_int32, c_size_t, c_void_p

HEADER = re.sub(r"/\*.*?\*/", "", pathlib.Path(sys.argv[1]).read_text(), flags=re.DOTALL)


def type_of(word, structs):
    if word in structs:
        return structs[word]
    return getattr(ctypes, "c_" + (word if word == "size_t" else word.removesuffix("_t")))


def fields_of(body, structs):
    """Pointers, of functions too, are void*."""
    for declaration in filter(None, map(str.strip, body.split(";"))):
        if "*" in declaration:
            yield re.search(r"\*\s*(\w+)", declaration)[1], c_void_p
            continue
        word, names = declaration.split(maxsplit=1)
        for name, count in re.findall(r"(\w+)(?:\[(\d+)\])?", names):
            yield name, type_of(word, structs) * int(count) if count else type_of(word, structs)


def structs_of(header):
    structs = {}
    for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\}", header, re.DOTALL):
        structs[name] = type(name, (ctypes.Structure,), {"_fields_": list(fields_of(body, structs))})
    return structs


STRUCTS = structs_of(HEADER)
STOP = ctypes.CFUNCTYPE(c_int32, c_void_p)
TAKE = ctypes.CFUNCTYPE(None, c_void_p, ctypes.POINTER(STRUCTS["lamella_layer_view"]))


def address(function):
    return ctypes.cast(function, c_void_p).value


def made(lamella, name):
    """A struct with its defaults."""
    struct = STRUCTS[f"lamella_{name}"]()
    kind = int(re.search(rf"LAMELLA_{name.upper()} = (\d+)", HEADER)[1])
    lamella.lamella_init_sized(byref(struct), kind, c_size_t(ctypes.sizeof(struct)))
    return struct


def slice_to(lamella, take, mesh, options, context, error):
    source, sink, to = made(lamella, "source"), made(lamella, "sink"), made(lamella, "destination")
    callback = TAKE(take)
    source.mesh, sink.take, to.sink = ctypes.addressof(mesh), address(callback), ctypes.addressof(sink)
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
    kept, context, layers = Kept(), made(lamella, "context"), []
    context.stop = address(kept.stop)

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
    lamella = ctypes.CDLL(sys.argv[2])
    with open(sys.argv[3], "rb") as file:
        stl = file.read()
    mesh, options, error = made(lamella, "mesh"), made(lamella, "options"), made(lamella, "error")
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
        origins = ctypes.cast(layer.origins, ctypes.POINTER(STRUCTS["lamella_point_origin"]))
        named.extend(origins[i].triangle for i in range(layer.point_count))

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
