// Measures of sections.
#include "lamella/measures.hpp"

#include "native.hpp"

namespace lamella::python {

namespace {

py::dtype measures_type() {
    std::vector<Field> fields = {
        {"layer", "i8", offsetof(SectionMeasures, layer)},     {"contour", "i8", offsetof(SectionMeasures, contour)},
        {"z", "f8", offsetof(SectionMeasures, z_mm)},          {"known", "?", offsetof(SectionMeasures, known)},
        {"islands", "i4", offsetof(SectionMeasures, islands)}, {"holes", "i4", offsetof(SectionMeasures, holes)},
        {"open", "i4", offsetof(SectionMeasures, open)}};
    std::size_t at = offsetof(SectionMeasures, area_mm2);  // the rest are numbers, one after another
    for (const char* const name : {"area",
                                   "outer_area",
                                   "perimeter",
                                   "outer_perimeter",
                                   "centroid_x",
                                   "centroid_y",
                                   "ix",
                                   "iy",
                                   "ixy",
                                   "imin",
                                   "imax",
                                   "angle",
                                   "polar",
                                   "box_min_x",
                                   "box_min_y",
                                   "box_max_x",
                                   "box_max_y",
                                   "feret_max",
                                   "feret_min",
                                   "feret_angle",
                                   "equivalent_diameter",
                                   "circularity"}) {
        fields.push_back({name, "f8", std::exchange(at, at + sizeof(double))});
    }
    return type_of<SectionMeasures>(fields);
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
