// Planes of any direction.
#include "lamella/sections.hpp"

#include <pybind11/stl.h>

#include "native.hpp"

namespace lamella::python {

namespace {

/// `frames`: (n, 3, 4).
HeldResult sections_of(const View& view, const Asked& asked, const py::array_t<double, py::array::c_style>& frames,
                       bool nearest) {
    const auto* const first = reinterpret_cast<const Transform*>(frames.data());
    const std::span<const Transform> all(first, static_cast<std::size_t>(frames.shape(0)));
    return HeldResult(run(asked, [&](const Context& context) -> Result<SliceResult> {
        Result<SliceResult> sections = slice_sections(view.mesh(), all, asked.options, context);
        return sections && nearest ? keep_nearest_islands(*sections, context) : std::move(sections);
    }));
}

}  // namespace

void define_sections(py::module_& module) {
    module.def("sections", &sections_of);
}

}  // namespace lamella::python
