#include "copy_bandwidth.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <map>

#include "base/parallel.hpp"
#include "lamella/array.hpp"

namespace lamella::bench {

namespace {

std::size_t copy_bytes = std::size_t{256} << 20;

double measure(int threads) {
    using Clock = std::chrono::steady_clock;
    Array<char> from;
    Array<char> to;
    from.resize_discarding(copy_bytes);
    to.resize_discarding(copy_bytes);
    std::memset(from.data(), 1, from.size());
    std::memset(to.data(), 2, to.size());
    const Parallel parallel({.threads = threads});
    std::array<double, 9> seconds{};
    for (double& took : seconds) {
        const auto start = Clock::now();
        parallel.run_ranges(from.size(), 1 << 20, [&](std::size_t begin, std::size_t end, int) {
            std::memcpy(to.data() + begin, from.data() + begin, end - begin);
        });
        took = std::chrono::duration<double>(Clock::now() - start).count();
    }
    std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
    return 2 * static_cast<double>(copy_bytes) / seconds[seconds.size() / 2];
}

}  // namespace

void set_copy_size(std::size_t bytes) {
    copy_bytes = bytes;
}

double copy_bandwidth(int threads) {
    static std::map<int, double> measured;
    const auto [at, fresh] = measured.try_emplace(threads, 0.0);
    if (fresh) {
        at->second = measure(threads);
    }
    return at->second;
}

}  // namespace lamella::bench
