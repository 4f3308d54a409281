// Two tasks write one integer without synchronisation. The thread sanitizer must report it; otherwise its silence about
// the engine would mean nothing.
#include <atomic>
#include <cstdio>

#include "base/parallel.hpp"

int main() {
    int shared = 0;
    std::atomic<int> begun{0};
    const lamella::Parallel parallel({.threads = 2});
    parallel.run(2, [&](std::size_t, int) {
        // Waits until both tasks run. The order is relaxed, so that waiting synchronises nothing.
        begun.fetch_add(1, std::memory_order_relaxed);
        while (begun.load(std::memory_order_relaxed) < 2) {
        }
        ++shared;
    });
    std::printf("%d\n", shared);
    return 0;
}
