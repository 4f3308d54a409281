// Two tasks write integers without synchronisation. The thread sanitizer must report it; otherwise its silence about the
// engine would mean nothing.
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <thread>
#include <vector>

#include "base/parallel.hpp"

int main() {
    std::vector<int> shared(1000);
    std::atomic<int> begun{0};
    const lamella::Parallel parallel({.threads = 2});
    // Threads are started by a run of some length.
    parallel.run(3, [](std::size_t, int) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); });
    parallel.run(2, [&](std::size_t task, int) {
        // Waits until both tasks run. The order is relaxed, so that waiting synchronises nothing.
        begun.fetch_add(1, std::memory_order_relaxed);
        while (begun.load(std::memory_order_relaxed) < 2) {
        }
        // From either end: of two writes at the very same moment the sanitizer may miss both.
        for (std::size_t i = 0; i < shared.size(); ++i) {
            ++shared[task == 0 ? i : shared.size() - 1 - i];
        }
    });
    std::printf("%d\n", shared.front());
    return 0;
}
