#include "options.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <thread>

namespace lamella::bench {

namespace {

/// The value of "--name=value".
std::optional<std::string_view> value_of(std::string_view argument, std::string_view name) {
    if (!argument.starts_with(name) || argument.size() <= name.size() || argument[name.size()] != '=') {
        return std::nullopt;
    }
    return argument.substr(name.size() + 1);
}

bool take(std::string_view argument, Options& options) {
    if (argument == "--quick") {
        options.quick = true;
    } else if (const auto cache = value_of(argument, "--cache")) {
        options.cache = *cache;
    } else if (const auto shared = value_of(argument, "--shared")) {
        options.shared = *shared;
    } else if (const auto threads = value_of(argument, "--max-threads")) {
        options.max_threads = std::max(0, std::atoi(threads->data()));
    } else {
        return false;
    }
    return true;
}

}  // namespace

Options take_options(std::vector<char*>& arguments) {
    Options options;
    std::erase_if(arguments, [&](const char* argument) { return take(argument, options); });
    return options;
}

std::vector<int> thread_counts(const Options& options) {
    const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    const int most = options.max_threads > 0 ? options.max_threads : cores;
    std::vector<int> counts;
    for (int threads = 1; threads < most; threads *= 2) {
        counts.push_back(threads);
    }
    counts.push_back(most);
    return counts;
}

}  // namespace lamella::bench
