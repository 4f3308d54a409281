// The slicing algorithms that the paper describes or compares find the same segments.
#include <cstring>
#include <random>
#include <tuple>

#include <catch2/catch.hpp>

#include "baselines/agreement.hpp"
#include "geometry.hpp"
#include "methods.hpp"
#include "oracle/oracle.hpp"

using agreement::Case;
using lamella::baselines::Problem;
using lamella::baselines::SegmentLists;
using lamella::baselines::SlicingMethod;

namespace {

/// Triangles by ascending lowest vertex.
std::vector<float> presorted(std::span<const float> soup) {
    std::vector<std::array<float, 9>> triangles(soup.size() / 9);
    std::memcpy(triangles.data(), soup.data(), soup.size() * sizeof(float));
    std::stable_sort(triangles.begin(), triangles.end(), [](const auto& a, const auto& b) {
        return std::min({a[2], a[5], a[8]}) < std::min({b[2], b[5], b[8]});
    });
    std::vector<float> sorted(soup.size());
    std::memcpy(sorted.data(), triangles.data(), soup.size() * sizeof(float));
    return sorted;
}

using Ends = std::tuple<std::int32_t, std::int32_t, std::int32_t, std::int32_t>;

template <class Segments>
std::vector<Ends> in_order(const Segments& segments) {
    std::vector<Ends> ends;
    ends.reserve(segments.size());
    for (const auto& segment : segments) {
        ends.emplace_back(segment.from.x, segment.from.y, segment.to.x, segment.to.y);
    }
    std::sort(ends.begin(), ends.end());
    return ends;
}

void require_oracles(const Case& given) {
    const std::vector<double> numbers(given.soup.begin(), given.soup.end());
    const std::vector<oracle::Triangle> triangles = oracle::quantise(numbers, given.problem.unit_mm);
    std::vector<std::vector<Ends>> expected;
    expected.reserve(given.problem.planes.size());
    for (const std::int32_t plane : given.problem.planes) {
        expected.push_back(in_order(oracle::segments_at(triangles, plane)));
    }
    const std::vector<float> sorted = presorted(given.soup);
    for (const SlicingMethod* method : lamella::baselines::slicing_methods) {
        if (!given.problem.uniform && method->uniform_only) {
            continue;
        }
        INFO(method->name);
        Problem problem = given.problem;
        if (method == &lamella::baselines::presorted_slicing) {
            problem.soup = sorted;
        }
        const SegmentLists lists = method->slice(problem);
        REQUIRE(lists.size() == expected.size());
        for (std::size_t i = 0; i < lists.size(); ++i) {
            INFO("plane " << i);
            REQUIRE((in_order(lists[i]) == expected[i]));
        }
    }
}

}  // namespace

TEST_CASE("baselines cut meshes into the oracle's segments", "[baselines]") {
    using lamella::models::Shape;
    for (const Shape shape : {Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism}) {
        const std::vector<float> soup = agreement::from_recipe(shape, 1500);
        require_oracles(Case(soup, uniform(0.25)));
        require_oracles(Case(soup, uniform(0.0371)));
        require_oracles(Case(soup, {}, agreement::irregular(0.01, 0.5)));
    }
    const std::vector<float> open = agreement::with_gaps(shapes::floats(agreement::nested_balls()), 7);
    require_oracles(Case(open, uniform(0.3)));
    require_oracles(Case(open, {}, agreement::irregular(0.1, 0.6)));
}

TEST_CASE("baselines drop degenerate triangles on a grid as coarse as the planes", "[baselines]") {
    const double unit_mm = GENERATE(0.5, 0.037);
    lamella::SliceOptions options = uniform(3.1 * unit_mm, unit_mm);
    require_oracles(Case(shapes::floats(shapes::octasphere({0.3, 0, 0.1}, 4, 5)), options));
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        INFO("seed " << seed);
        require_oracles(Case(shapes::floats(shapes::random_soup(seed, 40, 5)), options));
    }
}

TEST_CASE("planes below, above and between all triangles have no segments", "[baselines]") {
    lamella::SliceOptions options;
    options.heights_mm = std::vector<double>{-3, -2, 0.5, 2, 3, 4.5, 6, 7};
    require_oracles(Case(
        shapes::floats(shapes::joined({shapes::box({0, 0, 0}, {1, 1, 1}), shapes::box({0, 0, 4}, {1, 1, 5})})), options));
}

TEST_CASE("no planes or no triangles give no segments", "[baselines]") {
    const std::vector<float> soup = shapes::floats(shapes::box({0, 0, 0}, {1, 1, 1}));
    Problem no_planes;
    no_planes.soup = soup;
    Problem no_triangles;
    no_triangles.planes = {1, 3, 5};
    for (const bool uniform : {false, true}) {
        no_planes.uniform = no_triangles.uniform = uniform;
        no_triangles.first = 1;
        no_triangles.step = 2;
        for (const SlicingMethod* method : lamella::baselines::slicing_methods) {
            INFO(method->name);
            CHECK(method->slice(no_planes).empty());
            const SegmentLists lists = method->slice(no_triangles);
            CHECK(lists.size() == 3);
            CHECK(lists[0].size() + lists[1].size() + lists[2].size() == 0);
        }
    }
}

TEST_CASE("division finds the first plane above a height, however planes are rounded", "[baselines]") {
    std::mt19937_64 random(1);
    for (const double step : {2.3, 2.9, 7.0, 64.25, 1000.1}) {
        Problem problem;
        problem.uniform = true;
        problem.first = -40.6;
        problem.step = step;
        for (int i = 0; i < 300; ++i) {
            const auto odd = 2 * static_cast<std::int32_t>(std::floor((problem.first + i * step) / 2)) + 1;
            const std::int32_t off = step > 6 ? 2 * static_cast<std::int32_t>(random() % 3) - 2 : 0;
            if (problem.planes.empty() || odd + off > problem.planes.back()) {
                problem.planes.push_back(odd + off);
            }
        }
        const lamella::baselines::FirstPlaneAbove first_above(problem);
        for (std::int32_t z = problem.planes.front() - 9; z < problem.planes.back() + 9; z += 2) {
            const auto above = std::upper_bound(problem.planes.begin(), problem.planes.end(), z);
            REQUIRE(first_above(z) == static_cast<std::size_t>(above - problem.planes.begin()));
        }
    }
}
