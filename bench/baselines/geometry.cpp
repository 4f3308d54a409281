#include "geometry.hpp"

#include "slicing/grid/mesh_edge.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella::baselines {

std::vector<Facet> quantised(const Problem& problem) {
    std::vector<Facet> facets;
    facets.reserve(problem.facets());
    for (std::size_t t = 0; t < problem.facets(); ++t) {
        const float* numbers = problem.soup.data() + 9 * t;
        Facet facet;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const auto grid = [&](std::size_t axis) {
                return to_even_grid(static_cast<double>(numbers[3 * corner + axis]), problem.unit_mm);
            };
            facet[corner] = {grid(0), grid(1), grid(2)};
        }
        if (!is_degenerate(facet)) {
            facets.push_back(facet);
        }
    }
    return facets;
}

Point crossing(const GridVertex& a, const GridVertex& b, std::int32_t plane) noexcept {
    const GridVertex& low = a.z < b.z ? a : b;
    const GridVertex& high = a.z < b.z ? b : a;
    const double height = static_cast<double>(std::int64_t{high.z} - low.z);
    const double slope_x = static_cast<double>(std::int64_t{high.x} - low.x) / height;
    const double slope_y = static_cast<double>(std::int64_t{high.y} - low.y) / height;
    const auto rise = static_cast<double>(std::int64_t{plane} - low.z);
    return {low.x + round_move(slope_x * rise), low.y + round_move(slope_y * rise)};
}

Segment cut(const Facet& facet, std::int32_t plane) noexcept {
    Segment segment;
    for (std::size_t i = 0; i < 3; ++i) {
        const GridVertex& u = facet[i];
        const GridVertex& v = facet[(i + 1) % 3];
        if (is_cut(u, v, plane)) {
            (v.z < plane ? segment.from : segment.to) = crossing(u, v, plane);
        }
    }
    return segment;
}

}  // namespace lamella::baselines
