// Slices real meshes at the heights of their own vertices.
#include "engine/vertex_heights.hpp"
#include "engine/slicing.hpp"
#include "lamella/mesh/inspect.hpp"
#include "models_shared/real_meshes.hpp"

namespace {

/// Planes in one slice.
constexpr std::size_t most_planes = 2'000;

std::vector<std::vector<double>> parts_of(const std::vector<double>& heights) {
    std::vector<std::vector<double>> parts;
    for (std::size_t first = 0; first < heights.size(); first += most_planes) {
        const std::size_t count = std::min(most_planes, heights.size() - first);
        const auto begin = heights.begin() + static_cast<std::ptrdiff_t>(first);
        parts.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(count));
    }
    return parts;
}

}  // namespace

TEST_CASE("planes at the heights of all vertices lose no triangle of real meshes", "[vertex_heights]") {
    for (const std::filesystem::path& file : real_meshes()) {
        const shapes::Soup soup = soup_of(file);
        const lamella::MeshInfo info = *inspect(view_of(soup));
        std::uint64_t open = 0;
        for (const std::vector<double>& part : parts_of(vertex_heights(soup, info.unit_mm))) {
            for (const lamella::PlaneSide side : {lamella::PlaneSide::below, lamella::PlaneSide::above}) {
                lamella::SliceOptions options;
                options.plan.spacing = lamella::ExplicitPlanes{part};
                options.plan.side = side;
                const lamella::SliceResult result = sliced(soup, options);
                INFO(file << ", from " << part.front() << " mm, above " << (side == lamella::PlaneSide::above));
                CHECK(lost_at_vertex_heights(result, soup).empty());
                open += result.summary.open_contours;
            }
        }
        INFO(file);
        CHECK((!info.closed || open == 0));
    }
}
