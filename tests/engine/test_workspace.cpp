// Workspaces: what they hold, what they give back, and that a small call leaves the host's other threads alone.
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/slicing.hpp"

using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::Workspace;

namespace {

void slice_with(Workspace& workspace, const shapes::Soup& soup, const SliceOptions& options) {
    SliceResult result(options.control.memory);
    REQUIRE(slice(view_of(soup), options, workspace, result).ok());
}

shapes::Soup plate() {
    return shapes::box({0, 0, 0}, {20, 20, 2});
}

shapes::Soup large() {
    return shapes::octasphere({0, 0, 0}, 10, 7);
}

}  // namespace

TEST_CASE("a workspace says what it holds of the host's memory", "[engine][workspace]") {
    CountingMemory memory;
    SliceOptions options = uniform(0.1);
    options.control.memory = &memory;
    options.control.threads = GENERATE(1, 3);
    Workspace workspace;
    CHECK(workspace.bytes() == 0);
    slice_with(workspace, large(), options);
    CHECK(workspace.bytes() >= memory.held());
    CHECK(workspace.bytes() <= memory.held() + 65536);
    workspace.trim();
    CHECK(workspace.bytes() >= memory.held());
    CHECK(workspace.bytes() <= memory.held() + 65536);
    workspace.reset();
    CHECK(workspace.bytes() == 0);
    CHECK(memory.held() == 0);
}

TEST_CASE("a workspace gives back what the last call did not need", "[engine][workspace]") {
    SliceOptions thin = uniform(0.02);
    thin.control.threads = GENERATE(1, 3);
    SliceOptions small = uniform(1);
    small.control.threads = thin.control.threads;
    const bool with_regions = GENERATE(false, true);
    if (with_regions) {
        thin.region.fill_rule = lamella::FillRule::non_zero;
        thin.region.close_mm = 0.1;
    }
    Workspace fresh;
    slice_with(fresh, plate(), small);
    Workspace kept;
    slice_with(kept, large(), thin);
    const std::size_t large_bytes = kept.bytes();
    kept.trim();
    CHECK(kept.bytes() > large_bytes / 2);  // all of it may be needed again
    slice_with(kept, plate(), small);
    CHECK(kept.bytes() > large_bytes / 2);
    kept.trim();
    CHECK(kept.bytes() < 2 * fresh.bytes() + 32768);
    CHECK(kept.bytes() < large_bytes / 8);
}

TEST_CASE("a workspace that was trimmed gives the same answers", "[engine][workspace]") {
    const std::vector<shapes::Soup> soups = {plate(), large(), shapes::random_tetrahedra(3, 40, 5), plate()};
    Workspace workspace;
    SliceResult result;
    for (const shapes::Soup& soup : soups) {
        for (const double height : {0.5, 0.05}) {
            const SliceOptions options = uniform(height);
            REQUIRE(slice(view_of(soup), options, workspace, result).ok());
            CHECK(hash_result(result) == hash_result(sliced(soup, options)));
            workspace.trim();
        }
    }
}

TEST_CASE("a small slice is done by the calling thread alone", "[engine][workspace][executor]") {
    int runs = 0;
    auto pool = [&runs](int, const auto& body) noexcept {
        ++runs;
        body();
    };
    SliceOptions options = uniform(GENERATE(2.0, 0.1));
    options.control.executor = lamella::Executor::on(pool, 8);
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 1, 2);
    CHECK(hash_result(sliced(soup, options)) ==
          hash_result(sliced(
              soup, uniform(options.plan.spacing.index() == 0 ? std::get<0>(options.plan.spacing).layer_height_mm : 0))));
    CHECK(runs == 0);
}
