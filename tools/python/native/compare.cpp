// How alike two results are.
#include "lamella/compare.hpp"

#include "native.hpp"

namespace lamella::python {

namespace {

py::tuple comparison_of(const HeldResult& first, const HeldResult& second, bool distances, const Asked& asked) {
    const Comparison found = run(asked, [&](const Context& context) {
        return compare(first.result, second.result, {.distances = distances}, context);
    });
    const py::dtype row = type_of<LayerComparison>({{"layer", "i8", offsetof(LayerComparison, layer)},
                                                    {"z", "f8", offsetof(LayerComparison, z_mm)},
                                                    {"first", "f8", offsetof(LayerComparison, first_mm2)},
                                                    {"second", "f8", offsetof(LayerComparison, second_mm2)},
                                                    {"both", "f8", offsetof(LayerComparison, both_mm2)},
                                                    {"dice", "f8", offsetof(LayerComparison, dice)},
                                                    {"jaccard", "f8", offsetof(LayerComparison, jaccard)},
                                                    {"mean_distance", "f8", offsetof(LayerComparison, mean_distance_mm)},
                                                    {"hausdorff", "f8", offsetof(LayerComparison, hausdorff_mm)}});
    const LayerComparison& all = found.stack;
    return py::make_tuple(read_only(copy_of(found.layers, row)), all.dice, all.jaccard, all.mean_distance_mm,
                          all.hausdorff_mm);
}

}  // namespace

void define_compare(py::module_& module) {
    module.def("compare", &comparison_of);
}

}  // namespace lamella::python
