#include "forked.hpp"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace lamella::python {

namespace {

std::atomic<bool> is_forked = false;

void run_on_threads(void* /*context*/, int workers, void (*body)(void*) noexcept, void* argument) noexcept {
    std::vector<std::thread> threads;
    try {
        for (int worker = 1; worker < workers; ++worker) {
            threads.emplace_back(body, argument);
        }
    } catch (const std::exception&) {
        // Those that there are do the work.
    }
    body(argument);
    for (std::thread& thread : threads) {
        thread.join();
    }
}

}  // namespace

void watch_forks() {
    pthread_atfork(nullptr, nullptr, [] { is_forked.store(true); });
}

Executor executor_here() noexcept {
    if (!is_forked.load()) {
        return {};
    }
    return {&run_on_threads, nullptr, std::max(1, static_cast<int>(std::thread::hardware_concurrency()))};
}

}  // namespace lamella::python
