// Two tasks write one integer without synchronisation: the thread sanitizer must say so, or its silence about the engine
// would mean nothing.
#include <atomic>
#include <cstdio>

#include "base/parallel.hpp"

int main() {
    int shared = 0;
    std::atomic<int> begun{0};
    const lamella::Parallel parallel({.threads = 2});
    parallel.run(2, [&](std::size_t, int) {
        // Both run at once; relaxed, so that waiting orders nothing.
        begun.fetch_add(1, std::memory_order_relaxed);
        while (begun.load(std::memory_order_relaxed) < 2) {
        }
        ++shared;
    });
    std::printf("%d\n", shared);
    return 0;
}
