// Slicers: what they hold, what they give back, and that a small call leaves the host's other threads alone. And the
// recycler, whose blocks never overlap, and which uses again what is given back.
#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "base/recycler.hpp"
#include "engine/counting_memory.hpp"
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

TEST_CASE("blocks of a recycler keep what is written to them", "[engine][memory]") {
    struct Block {
        std::byte* at;
        std::size_t bytes;
        std::byte mark;
    };
    lamella::Recycler recycler;
    const lamella::Memory& memory = *recycler.memory();
    std::mt19937 random(6);
    std::vector<Block> blocks;
    const auto give_back = [&](std::size_t i) {
        const Block block = blocks[i];
        CHECK(std::all_of(block.at, block.at + block.bytes, [&](std::byte b) { return b == block.mark; }));
        memory.release(block.at, block.bytes, 64);
        blocks.erase(blocks.begin() + static_cast<std::ptrdiff_t>(i));
    };
    for (int step = 0; step < 300; ++step) {
        if (blocks.size() < 12 && random() % 5 < 3) {
            const std::size_t bytes = random() % 4 == 0 ? 1 + random() % 5000 : (1 << 20) + random() % (3 << 20);
            auto* const at = static_cast<std::byte*>(memory.allocate(bytes, 64));
            REQUIRE(at != nullptr);
            CHECK(reinterpret_cast<std::uintptr_t>(at) % 64 == 0);
            const auto mark = static_cast<std::byte>(step);
            std::memset(at, step & 0xFF, bytes);
            blocks.push_back({at, bytes, mark});
        } else if (!blocks.empty()) {
            give_back(random() % blocks.size());
        }
    }
    while (!blocks.empty()) {
        give_back(0);
    }
}

TEST_CASE("a recycler joins what is given back, and hands it out again", "[engine][memory]") {
    lamella::Recycler recycler;
    const std::size_t whole = std::size_t{8} << 20;
    auto* const first = static_cast<std::byte*>(recycler.allocate(whole, 64));
    recycler.deallocate(first, whole, 64);
    std::vector<std::byte*> quarters;
    for (int i = 0; i < 4; ++i) {
        quarters.push_back(static_cast<std::byte*>(recycler.allocate(whole / 4, 64)));
        CHECK(quarters.back() >= first);
        CHECK(quarters.back() + whole / 4 <= first + whole);
    }
    for (const int i : {2, 0, 3, 1}) {
        recycler.deallocate(quarters[static_cast<std::size_t>(i)], whole / 4, 64);
    }
    void* const again = recycler.allocate(whole, 64);
    CHECK(again == first);
    recycler.deallocate(again, whole, 64);
}
