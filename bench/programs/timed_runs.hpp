// What the programs that time one method on one mesh share.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "lamella/error.hpp"

namespace lamella::bench {

template <class T>
T checked(Result<T> result) {
    if (!result) {
        throw std::runtime_error(result.error().message);
    }
    return std::move(result).value();
}

extern "C" inline void end_at_limit(int) {
    constexpr int over_limit = 75;
    _exit(over_limit);
}

/// Ends the process with status 75 after `seconds`; 0: never.
inline void end_after(unsigned seconds) {
    std::signal(SIGALRM, end_at_limit);
    alarm(seconds);
}

/// Runs five times if a run takes less than 2 s, three times if less than 10 s, else once.
template <class RunOnce>
auto repeated(const RunOnce& run_once) {
    std::vector<decltype(run_once())> runs;
    for (std::size_t wanted = 1; runs.size() < wanted;) {
        runs.push_back(run_once());
        wanted = runs[0].sum() < 2 ? 5 : (runs[0].sum() < 10 ? 3 : 1);
    }
    return runs;
}

/// The peak memory of the process so far.
inline std::uint64_t peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace lamella::bench
