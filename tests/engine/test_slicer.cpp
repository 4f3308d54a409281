// Slicers: what they hold, what they give back, and that a small call leaves the host's other threads alone.
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/same_result.hpp"
#include "engine/slicing.hpp"

using lamella::SliceOptions;
using lamella::Slicer;
using lamella::SliceResult;

namespace {

void slice_with(Slicer& slicer, const shapes::Soup& soup, const SliceOptions& options, const lamella::Context& context) {
    REQUIRE(slicer.slice(view_of(soup), options, context).ok());
}

shapes::Soup plate() {
    return shapes::box({0, 0, 0}, {20, 20, 2});
}

shapes::Soup large() {
    return shapes::octasphere({0, 0, 0}, 10, 7);
}

}  // namespace

TEST_CASE("a slicer says what it holds of the host's memory", "[engine][slicer]") {
    CountingMemory memory;
    Slicer slicer;
    CHECK(slicer.bytes() == 0);
    slice_with(slicer, large(), uniform(0.1), {.threads = GENERATE(1, 3), .memory = &memory});
    for (int trims = 0; trims < 2; ++trims) {
        CHECK(slicer.bytes() >= memory.held());
        CHECK(slicer.bytes() <= memory.held() + 65536);
        slicer.trim();
    }
    slicer.reset();
    CHECK(slicer.bytes() == 0);
    CHECK(memory.held() == 0);
}

TEST_CASE("a slicer gives back what the last call did not need", "[engine][slicer]") {
    const lamella::Context context{.threads = GENERATE(1, 3)};
    SliceOptions thin = uniform(0.02);
    const bool with_regions = GENERATE(false, true);
    if (with_regions) {
        thin.region.fill_rule = lamella::FillRule::non_zero;
        thin.region.closing_mm = 0.1;
    }
    Slicer fresh;
    slice_with(fresh, plate(), uniform(1), context);
    Slicer kept;
    slice_with(kept, large(), thin, context);
    const std::size_t large_bytes = kept.bytes();
    kept.trim();
    CHECK(kept.bytes() > large_bytes / 2);  // all of it may be needed again
    slice_with(kept, plate(), uniform(1), context);
    CHECK(kept.bytes() > large_bytes / 2);
    kept.trim();
    CHECK(kept.bytes() < 2 * fresh.bytes() + 32768);
    CHECK(kept.bytes() < large_bytes / 8);
}

TEST_CASE("a slicer and its result give the same answers again, trimmed or not, whatever was asked before or refused",
          "[engine][slicer]") {
    const std::vector<shapes::Soup> soups = {plate(), large(), shapes::random_tetrahedra(3, 40, 5), {}, plate()};
    std::vector<SliceOptions> asked = {uniform(0.5), uniform(0.05), uniform(0.5), at_heights({2, 1, 2}), at_heights({})};
    asked[1].origins = true;
    asked[2].region.simplify_mm = 0.05;
    const shapes::Soup broken(18, 1e300);
    Slicer slicer;
    SliceResult result;
    for (const bool trims : {false, true}) {
        for (const shapes::Soup& soup : soups) {
            for (SliceOptions options : asked) {
                options.allow_empty = true;
                REQUIRE(slicer.slice_to(result, view_of(soup), options).ok());
                require_same(result, sliced(soup, options));
                CHECK_FALSE(slicer.slice_to(result, view_of(broken), options).ok());
                if (trims) {
                    slicer.trim();
                }
            }
        }
    }
}

TEST_CASE("a small slice is done by the calling thread alone", "[engine][slicer][executor]") {
    int runs = 0;
    const auto pool = [&runs](int, lamella::Callback<void()> body) noexcept {
        ++runs;
        body();
    };
    const SliceOptions options = uniform(GENERATE(2.0, 0.1));
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 1, 2);
    const SliceResult pooled = sliced(soup, options, {.executor = pool, .executor_threads = 8});
    CHECK(pooled.hash() == sliced(soup, options).hash());
    CHECK(runs == 0);
}
