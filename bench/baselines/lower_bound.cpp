// Minetto et al. 2017, section 3.5. Triangles stand side by side. The cell of the xy plane in which a triangle stands
// encodes its number:
//
//     planes[i] + 1              .
//     planes[i]        ---------/-\---------   the only plane that cuts it
//     value                    /___\           anywhere between planes[i - 1] and planes[i]
#include "lower_bound.hpp"

#include <cmath>

#include "models/numbers.hpp"
#include "slice_incremental.hpp"

namespace lamella::baselines {

namespace {

constexpr std::int32_t highest_z = 1 << 25;  // float represents every even number up to here exactly
constexpr std::int32_t cell_units = 8;
constexpr std::uint32_t cells_in_row = 1 << 15;

std::vector<std::int32_t> random_planes(std::uint32_t k, models::Random& random) {
    const std::uint32_t widest = static_cast<std::uint32_t>(highest_z) / 2 / k;
    std::vector<std::int32_t> planes;
    planes.reserve(k);
    std::int32_t z = -1;
    for (std::uint32_t i = 0; i < k; ++i) {
        z += 2 * static_cast<std::int32_t>(1 + random.below(widest));
        planes.push_back(z);
    }
    return planes;
}

Facet facet_of(std::uint32_t number, std::int32_t value, std::int32_t plane) {
    const std::int32_t x = cell_units * static_cast<std::int32_t>(number % cells_in_row);
    const std::int32_t y = cell_units * static_cast<std::int32_t>(number / cells_in_row);
    return {GridVertex{x, y, value}, GridVertex{x + cell_units - 2, y, value}, GridVertex{x + 2, y + 2, plane + 1}};
}

std::uint32_t number_at(Point point) {
    return static_cast<std::uint32_t>(point.y / cell_units) * cells_in_row +
           static_cast<std::uint32_t>(point.x / cell_units);
}

struct CountingLess {
    std::uint64_t* count;
    bool operator()(std::int32_t a, std::int32_t b) const noexcept {
        ++*count;
        return a < b;
    }
};

}  // namespace

Problem SearchInstance::problem() const {
    Problem problem;
    problem.soup = soup;
    problem.planes = planes;
    return problem;
}

SearchInstance make_search_instance(std::uint32_t n, std::uint32_t k, std::uint64_t seed) {
    models::Random random(seed);
    SearchInstance instance;
    instance.planes = random_planes(k, random);
    instance.soup.reserve(std::size_t{9} * n);
    instance.solution.reserve(n);
    for (std::uint32_t j = 0; j < n; ++j) {
        const std::uint32_t i = random.below(k);
        const std::int32_t plane = instance.planes[i];
        const std::int32_t below = i == 0 ? -1 : instance.planes[i - 1];
        const std::int32_t value =
            below + 1 + 2 * static_cast<std::int32_t>(random.below(static_cast<std::uint32_t>(plane - below) / 2));
        for (const GridVertex& vertex : facet_of(j, value, plane)) {
            for (const std::int32_t units : {vertex.x, vertex.y, vertex.z}) {
                instance.soup.push_back(static_cast<float>(units * default_grid_mm));
            }
        }
        instance.solution.push_back(i);
    }
    return instance;
}

std::vector<std::uint32_t> solution_of(const SegmentLists& segments, std::size_t n) {
    std::vector<std::uint32_t> solution(n, static_cast<std::uint32_t>(segments.size()));
    for (std::size_t i = 0; i < segments.size(); ++i) {
        for (const Segment& segment : segments[i]) {
            solution[number_at(segment.from)] = static_cast<std::uint32_t>(i);
        }
    }
    return solution;
}

ComparisonCount count_comparisons(const Problem& problem) {
    const std::vector<Facet> facets = quantised(problem);
    ComparisonCount count;
    count.least = static_cast<double>(facets.size()) * std::log2(static_cast<double>(problem.planes.size()));
    plane_sweep(lists_by_search(facets, problem, CountingLess{&count.search}), problem, CountingLess{&count.sweep});
    return count;
}

}  // namespace lamella::baselines
