// Measures of sections.
#include "lamella/measures.hpp"

#include "native.hpp"

namespace lamella::python {

namespace {

py::dtype measures_type() {
#define MEASURE(name, format, member) \
    { name, format, offsetof(SectionMeasures, member) }
#define MEASURE_Y(name, member) \
    { name, "f8", offsetof(SectionMeasures, member) + sizeof(double) }
    return type_of<SectionMeasures>({MEASURE("layer", "i8", layer),
                                     MEASURE("contour", "i8", contour),
                                     MEASURE("z", "f8", z_mm),
                                     MEASURE("known", "?", known),
                                     MEASURE("islands", "i4", islands),
                                     MEASURE("holes", "i4", holes),
                                     MEASURE("open", "i4", open),
                                     MEASURE("area", "f8", area_mm2),
                                     MEASURE("outer_area", "f8", outer_area_mm2),
                                     MEASURE("perimeter", "f8", perimeter_mm),
                                     MEASURE("outer_perimeter", "f8", outer_perimeter_mm),
                                     MEASURE("centroid_x", "f8", centroid_mm),
                                     MEASURE_Y("centroid_y", centroid_mm),
                                     MEASURE("ix", "f8", ix_mm4),
                                     MEASURE("iy", "f8", iy_mm4),
                                     MEASURE("ixy", "f8", ixy_mm4),
                                     MEASURE("imin", "f8", imin_mm4),
                                     MEASURE("imax", "f8", imax_mm4),
                                     MEASURE("angle", "f8", angle_rad),
                                     MEASURE("polar", "f8", polar_mm4),
                                     MEASURE("box_min_x", "f8", box_min_mm),
                                     MEASURE_Y("box_min_y", box_min_mm),
                                     MEASURE("box_max_x", "f8", box_max_mm),
                                     MEASURE_Y("box_max_y", box_max_mm),
                                     MEASURE("feret_max", "f8", feret_max_mm),
                                     MEASURE("feret_min", "f8", feret_min_mm),
                                     MEASURE("feret_angle", "f8", feret_angle_rad),
                                     MEASURE("equivalent_diameter", "f8", equivalent_diameter_mm),
                                     MEASURE("circularity", "f8", circularity)});
#undef MEASURE
#undef MEASURE_Y
}

/// Rows of layers, or of islands.
py::array measures_of(const HeldResult& held, bool islands, bool feret) {
    const Measures found =
        run([&](const Context& context) { return measure(held.result, {.islands = islands, .feret = feret}, context); });
    return read_only(copy_of(islands ? found.islands : found.layers, measures_type()));
}

}  // namespace

void define_measures(py::module_& module) {
    module.def("measures", &measures_of);
}

}  // namespace lamella::python
