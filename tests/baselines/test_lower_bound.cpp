// Multipoint search posed as slicing (paper 3.5).
#include <algorithm>
#include <cmath>
#include <functional>

#include <catch2/catch.hpp>

#include "lower_bound.hpp"
#include "methods.hpp"
#include "slice_incremental.hpp"

namespace baselines = lamella::baselines;
using baselines::ComparisonCount;
using baselines::Problem;
using baselines::SearchInstance;
using baselines::SegmentLists;
using baselines::SlicingMethod;

TEST_CASE("slicing solves multipoint search", "[baselines]") {
    for (const std::uint32_t k : {1U, 2U, 7U, 300U, 1U << 12}) {
        INFO(k << " planes");
        const SearchInstance instance = baselines::make_search_instance(1000, k, 3 + k);
        const Problem problem = instance.problem();
        REQUIRE(problem.facets() == 1000);
        REQUIRE(std::is_sorted(problem.planes.begin(), problem.planes.end(), std::less_equal<>()));
        for (const SlicingMethod* method : {&baselines::trivial_slicing, &baselines::tata_slicing,
                                            &baselines::incremental_slicing, &baselines::sort_first_slicing}) {
            INFO(method->name);
            const SegmentLists segments = method->slice(problem);
            std::size_t m = 0;
            for (const auto& list : segments) {
                m += list.size();
            }
            CHECK(m == 1000);
            CHECK((baselines::solution_of(segments, 1000) == instance.solution));
        }
    }
}

TEST_CASE("a search instance has the answers that its heights give", "[baselines]") {
    const SearchInstance instance = baselines::make_search_instance(40'000, 100, 1);
    const Problem problem = instance.problem();
    const std::vector<baselines::Facet> facets = baselines::quantised(problem);
    std::vector<int> met(100);
    for (std::size_t j = 0; j < facets.size(); ++j) {
        const auto above = std::upper_bound(problem.planes.begin(), problem.planes.end(), baselines::z_min(facets[j]));
        REQUIRE(above - problem.planes.begin() == instance.solution[j]);
        REQUIRE(baselines::z_max(facets[j]) == *above + 1);
        ++met[instance.solution[j]];
    }
    CHECK(*std::min_element(met.begin(), met.end()) > 300);  // about 400 each
}

TEST_CASE("a triangle that no plane cuts has no answer", "[baselines]") {
    CHECK((baselines::solution_of(SegmentLists(3), 2) == std::vector<std::uint32_t>{3, 3}));
}

TEST_CASE("searching takes n log k comparisons or a few more, never fewer", "[baselines]") {
    constexpr std::uint32_t n = 20'000;
    for (const std::uint32_t k : {16U, 1000U, 1U << 14}) {
        INFO(k << " planes");
        const ComparisonCount count = baselines::count_comparisons(baselines::make_search_instance(n, k, 5).problem());
        CHECK(count.least == Approx(n * std::log2(k)));
        CHECK(static_cast<double>(count.search) > count.least);
        CHECK(count.search <= n * (1 + static_cast<std::uint64_t>(std::ceil(std::log2(k)))));
        CHECK(count.sweep <= 2 * n);  // fewer, because no plane follows the last one
        CHECK(count.sweep > 2 * n - n / 8);
    }
}
