// Records are brought to the lists of their first planes in place.
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "base/parallel.hpp"
#include "slicing/buckets/listed_triangles.hpp"

namespace {

using lamella::CrossedTriangle;
using lamella::PlaneIndex;

/// Numbered in `last`.
std::vector<CrossedTriangle> records_of(const std::vector<PlaneIndex>& firsts) {
    std::vector<CrossedTriangle> records(firsts.size());
    for (std::uint32_t i = 0; i < records.size(); ++i) {
        records[i].first = firsts[i];
        records[i].last = i;
    }
    return records;
}

void require_sorted(const std::vector<PlaneIndex>& firsts, PlaneIndex base, PlaneIndex lists, int threads) {
    std::vector<std::uint32_t> begins(lists + 1, 0);
    for (const PlaneIndex first : firsts) {
        ++begins[std::max(first, base) - base + 1];
    }
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    std::vector<CrossedTriangle> records = records_of(firsts);
    lamella::sort_into_lists(records, base, begins, lamella::Parallel({.threads = threads}));
    std::vector<char> seen(firsts.size(), 0);
    std::size_t wrong = 0;
    for (PlaneIndex list = 0; list < lists; ++list) {
        for (std::uint32_t i = begins[list]; i < begins[list + 1]; ++i) {
            const CrossedTriangle& record = records[i];
            wrong += std::max(record.first, base) - base != list || record.first != firsts[record.last] ? 1 : 0;
            seen[record.last] = 1;
        }
    }
    CHECK(wrong == 0);
    CHECK(std::find(seen.begin(), seen.end(), 0) == seen.end());
}

}  // namespace

TEST_CASE("records are sorted into lists in place, whatever their order and the threads", "[buckets][threads]") {
    constexpr std::size_t count = 50'000;
    const PlaneIndex lists = GENERATE(1U, 2U, 17U, 1000U, 60'000U);
    const PlaneIndex base = GENERATE(0U, 5U);
    const int threads = GENERATE(1, 2, 3, 8);
    std::mt19937 random(lists + base);
    std::vector<PlaneIndex> firsts(count);
    std::generate(firsts.begin(), firsts.end(), [&] { return static_cast<PlaneIndex>(random() % (base + lists)); });
    INFO(lists << " lists from plane " << base << " on, " << threads << " threads");
    require_sorted(firsts, base, lists, threads);
    std::sort(firsts.begin(), firsts.end());
    require_sorted(firsts, base, lists, threads);
    std::reverse(firsts.begin(), firsts.end());
    require_sorted(firsts, base, lists, threads);
    std::fill_n(firsts.begin(), count / 2, base + lists - 1);
    require_sorted(firsts, base, lists, threads);
    require_sorted({}, base, lists, threads);
}
