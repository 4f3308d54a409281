// Blocks of a recycler never overlap, and what is given back is used again.
#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "base/recycler.hpp"

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
        memory.release(memory.context, block.at, block.bytes, 64);
        blocks.erase(blocks.begin() + static_cast<std::ptrdiff_t>(i));
    };
    for (int step = 0; step < 300; ++step) {
        if (blocks.size() < 12 && random() % 5 < 3) {
            const std::size_t bytes = random() % 4 == 0 ? 1 + random() % 5000 : (1 << 20) + random() % (3 << 20);
            auto* const at = static_cast<std::byte*>(memory.allocate(memory.context, bytes, 64));
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
