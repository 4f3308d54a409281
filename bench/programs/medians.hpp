// Medians of what takes turns, so that a change of the machine's load falls on all.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace lamella::bench {

struct Timed {
    std::string name;
    std::function<void()> work;
};

template <class Work>
double ms_of(const Work& work) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    work();
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
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

}  // namespace lamella::bench
