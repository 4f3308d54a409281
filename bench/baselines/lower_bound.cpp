// Minetto et al. 2017, section 3.5. Triangles stand side by side along x, in the order of their numbers:
//
//     planes[i] + 1              .
//     planes[i]        ---------/-\---------   the only plane that cuts it
//     value                    /___\           anywhere between planes[i - 1] and planes[i]
#include "lower_bound.hpp"

#include "models/numbers.hpp"

namespace lamella::baselines {

namespace {

constexpr std::uint32_t highest = 1 << 25;  // float represents every even number up to here exactly
constexpr std::int32_t width = 8;

}  // namespace

SearchInstance make_search_instance(std::uint32_t n, std::uint32_t k) {
    models::Random random(1);
    const auto random_even = [&](std::uint32_t bound) { return 2 * static_cast<std::int32_t>(random.below(bound)); };
    SearchInstance instance;
    instance.planes.reserve(k);
    for (std::int32_t z = -1; instance.planes.size() < k;) {
        instance.planes.push_back(z += 2 + random_even(highest / 2 / k));
    }
    instance.soup.reserve(std::size_t{9} * n);
    instance.solution.reserve(n);
    for (std::uint32_t j = 0; j < n; ++j) {
        const std::uint32_t i = instance.solution.emplace_back(random.below(k));
        const std::int32_t plane = instance.planes[i];
        const std::int32_t below = i == 0 ? -1 : instance.planes[i - 1];
        const std::int32_t value = below + 1 + random_even(static_cast<std::uint32_t>(plane - below) / 2);
        const std::int32_t x = width * static_cast<std::int32_t>(j);
        for (const std::int32_t units : {x, 0, value, x + width - 2, 0, value, x + 2, 2, plane + 1}) {
            instance.soup.push_back(static_cast<float>(units * default_grid_mm));
        }
    }
    return instance;
}

std::vector<std::uint32_t> solution_of(const SegmentLists& segments, std::size_t n) {
    std::vector<std::uint32_t> solution(n, static_cast<std::uint32_t>(segments.size()));
    for (std::size_t i = 0; i < segments.size(); ++i) {
        for (const Segment& segment : segments[i]) {
            solution[static_cast<std::size_t>(segment.from.x / width)] = static_cast<std::uint32_t>(i);
        }
    }
    return solution;
}

}  // namespace lamella::baselines
