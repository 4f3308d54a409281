// Shared by the programs that time calls: medians of calls that take turns, so that a change of the machine's load falls on
// all; limits; failures as exceptions.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/clock.hpp"
#include "lamella/error.hpp"

namespace lamella::bench {

using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

[[noreturn]] inline void fail(const std::string& why) {
    throw std::runtime_error(why);
}

template <class T>
T checked(Result<T> result) {
    if (!result) {
        fail(result.error().message);
    }
    return std::move(result).value();
}

/// A program's main(): run(words) takes as many words as the usage has, and prints a line of JSON.
template <class Run>
int run_program(int count, char** words, const char* usage, const Run& run) noexcept try {
    const auto wanted = usage[0] == '\0' ? 0 : 1 + std::count(usage, usage + std::char_traits<char>::length(usage), ' ');
    if (count - 1 != wanted) {
        std::fprintf(stderr, "usage: %s %s\n", words[0], usage);
        return 2;
    }
    run(Words(words + 1, words + count));
    return 0;
} catch (const std::exception& failure) {
    std::fprintf(stderr, "%s: %s\n", words[0], failure.what());
    return 1;
}

inline void print(const Json& line) {
    std::puts(line.dump().c_str());
    std::fflush(stdout);
}

template <class Work>
double ms_of(const Work& work) {
    const auto start = Clock::now();
    work();
    return milliseconds_since(start);
}

inline double seconds_since(Clock::time_point start) {
    return milliseconds_since(start) / 1000;
}

template <class Work>
double seconds_of(const Work& work) {
    return ms_of(work) / 1000;
}

inline double median_of(std::vector<double> times) {
    const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
    std::nth_element(times.begin(), middle, times.end());
    return *middle;
}

using Figures = std::map<std::string, double>;

/// Milliseconds by name. Each is run `rounds` times, and once before, which only warms.
inline Figures medians_of(const std::map<std::string, std::function<void()>>& works, int rounds) {
    std::map<std::string, std::vector<double>> times;
    for (int round = 0; round <= rounds; ++round) {
        for (const auto& [name, work] : works) {
            const double ms = ms_of(work);
            if (round > 0) {
                times[name].push_back(ms);
            }
        }
    }
    Figures medians;
    for (const auto& [name, all] : times) {
        medians[name] = median_of(all);
    }
    return medians;
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

/// Runs five times if a run takes less than 2 s, three times if less than 10 s, else once. The seconds of each run's steps,
/// step by step.
template <std::size_t Steps, class RunOnce>
std::array<std::vector<double>, Steps> repeated(const RunOnce& run_once) {
    std::array<std::vector<double>, Steps> all;
    for (std::size_t wanted = 1; all[0].size() < wanted;) {
        const std::array<double, Steps> run = run_once();
        double sum = 0;
        for (std::size_t step = 0; step < Steps; ++step) {
            all[step].push_back(run[step]);
            sum += run[step];
        }
        if (all[0].size() == 1) {
            wanted = sum < 2 ? 5 : (sum < 10 ? 3 : 1);
        }
    }
    return all;
}

/// The peak memory of the process so far.
inline std::uint64_t peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace lamella::bench
