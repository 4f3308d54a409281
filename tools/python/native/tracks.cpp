// Islands from layer to layer.
#include "lamella/tracks.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

py::dict tracks_of(const HeldResult& held, bool pockets, const Asked& asked) {
    const Tracks found =
        run(asked, [&](const Context& context) { return find_tracks(held.result, {.pockets = pockets}, context); });
    const py::dtype island = type_of<Track>({{"layer", "i8", offsetof(Track, layer)},
                                             {"contour", "i8", offsetof(Track, contour)},
                                             {"area", "f8", offsetof(Track, area_mm2)},
                                             {"centroid", "2f8", offsetof(Track, centroid_mm)},
                                             {"first_above", "u4", offsetof(Track, first_above)},
                                             {"above", "u4", offsetof(Track, above)},
                                             {"first_below", "u4", offsetof(Track, first_below)},
                                             {"below", "u4", offsetof(Track, below)},
                                             {"body", "u4", offsetof(Track, body)}});
    const py::dtype pocket = type_of<Pocket>({{"contour", "i8", offsetof(Pocket, contour)},
                                              {"first_layer", "i8", offsetof(Pocket, first_layer)},
                                              {"end_layer", "i8", offsetof(Pocket, end_layer)},
                                              {"volume", "f8", offsetof(Pocket, volume_mm3)},
                                              {"is_cavity", "?", offsetof(Pocket, is_cavity)}});
    return py::dict("islands"_a = copy_of(found.islands, island), "links"_a = copy_of(found.links, py::dtype("(2,)u4")),
                    "links_by_upper"_a = copy_of(found.links_by_upper, py::dtype::of<std::uint32_t>()),
                    "pockets"_a = copy_of(found.pockets, pocket), "bodies"_a = found.bodies);
}

}  // namespace

void define_tracks(py::module_& module) {
    module.def("tracks", &tracks_of);
}

}  // namespace lamella::python
