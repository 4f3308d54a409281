// Shared by the programs that time calls: medians of calls that take turns, so that a change of the machine's load falls on
// all; limits; failures as exceptions.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/clock.hpp"
#include "lamella/error.hpp"

namespace lamella::bench {

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

/// Calls run(words) of the program's arguments, and prints what it returns or throws. The exit status of main(): 2 unless
/// there are so many words.
template <class Run>
int run_program(int count, char** words, std::size_t least, std::size_t most, const char* usage, const Run& run) noexcept
    try {
    const std::vector<std::string> arguments(words + 1, words + count);
    if (arguments.size() < least || arguments.size() > most) {
        std::fprintf(stderr, "usage: %s %s\n", words[0], usage);
        return 2;
    }
    if constexpr (std::is_void_v<decltype(run(arguments))>) {
        run(arguments);
    } else {
        std::puts(run(arguments).dump().c_str());
    }
    return 0;
} catch (const std::exception& failure) {
    std::fprintf(stderr, "%s: %s\n", words[0], failure.what());
    return 1;
}

struct Timed {
    std::string name;
    std::function<void()> work;
};

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

/// Milliseconds by name. Each is run `rounds` times, and once before, which only warms.
inline nlohmann::ordered_json medians_of(const std::vector<Timed>& all, int rounds) {
    std::map<std::string, std::vector<double>> times;
    for (int round = 0; round <= rounds; ++round) {
        for (const Timed& each : all) {
            const double ms = ms_of(each.work);
            if (round > 0) {
                times[each.name].push_back(ms);
            }
        }
    }
    nlohmann::ordered_json medians;
    for (const Timed& each : all) {
        medians[each.name] = median_of(times[each.name]);
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

/// One member of every run.
template <class Run>
std::vector<double> values_of(const std::vector<Run>& runs, double Run::*member) {
    std::vector<double> values;
    for (const Run& run : runs) {
        values.push_back(run.*member);
    }
    return values;
}

/// Calls work(worker, item) for every item below `count`. Each worker runs on a thread of its own; worker 0 runs on the
/// calling thread.
template <class Work>
void share_out(std::size_t count, int threads, const Work& work) {
    std::atomic<std::size_t> next = 0;
    const auto take_items = [&](std::size_t worker) {
        for (std::size_t item = next++; item < count; item = next++) {
            work(worker, item);
        }
    };
    std::vector<std::jthread> others;
    for (std::size_t worker = 1; worker < static_cast<std::size_t>(threads); ++worker) {
        others.emplace_back(take_items, worker);
    }
    take_items(0);
}

/// The peak memory of the process so far.
inline std::uint64_t peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace lamella::bench
