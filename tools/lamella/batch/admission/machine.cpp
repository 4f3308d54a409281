#include "batch/admission/machine.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

#include <sched.h>

#include "terminal/numbers.hpp"

namespace lamella::cli::batch {

namespace {

constexpr std::uint64_t least_memory = std::uint64_t{32} << 20;
constexpr auto unlimited = std::numeric_limits<std::uint64_t>::max();

/// The first word of a file as a number; "max" is none.
std::optional<double> number_in(const std::string& path) {
    std::ifstream file(path);
    std::string word;
    file >> word;
    return parse_number(word);
}

/// The folders of this process's control group and of those above it, of `controller` ("" in version 2).
std::string group_of(const std::string& controller) {
    std::ifstream file("/proc/self/cgroup");
    for (std::string line; std::getline(file, line);) {
        const std::size_t first = line.find(':');
        const std::size_t second = line.find(':', first + 1);
        if (second != std::string::npos && line.substr(first + 1, second - first - 1) == controller) {
            return line.substr(second + 1);
        }
    }
    return {};
}

/// Calls `use` with the folder of each control group from this process's up to the root.
template <class Use>
void for_each_group(const std::string& mount, std::string group, const Use& use) {
    while (true) {
        use(mount + group + "/");
        const std::size_t slash = group.rfind('/');
        if (slash == std::string::npos || group.empty()) {
            return;
        }
        group.resize(slash);
    }
}

std::uint64_t group_memory() {
    double least = std::numeric_limits<double>::infinity();
    const auto take = [&](const std::string& path) { least = std::min(least, number_in(path).value_or(least)); };
    for_each_group("/sys/fs/cgroup", group_of(""), [&](const std::string& folder) { take(folder + "memory.max"); });
    for_each_group("/sys/fs/cgroup/memory", group_of("memory"),
                   [&](const std::string& folder) { take(folder + "memory.limit_in_bytes"); });
    return least < 1e18 ? static_cast<std::uint64_t>(least) : unlimited;
}

/// A line of /proc/meminfo.
std::uint64_t machine_memory(std::string_view key) {
    std::ifstream file("/proc/meminfo");
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with(key)) {
            std::istringstream words(line.substr(key.size()));
            std::uint64_t kilobytes = 0;
            words >> kilobytes;
            return kilobytes * 1024;
        }
    }
    return unlimited;
}

/// "200000 100000" in cpu.max: two processors.
int group_threads() {
    double least = std::numeric_limits<int>::max();
    for_each_group("/sys/fs/cgroup", group_of(""), [&](const std::string& folder) {
        std::ifstream file(folder + "cpu.max");
        std::string quota;
        double period = 0;
        if (file >> quota >> period && period > 0) {
            least = std::min(least, parse_number(quota).value_or(least * period) / period);
        }
    });
    return static_cast<int>(std::max(1.0, std::ceil(least)));
}

}  // namespace

int usable_threads() {
    cpu_set_t set;
    CPU_ZERO(&set);
    const int own = ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return std::max(1, std::min(own, group_threads()));
}

std::uint64_t usable_memory() {
    const std::uint64_t all = std::min(machine_memory("MemTotal:"), group_memory());
    const std::uint64_t share = all / 4 * 3;
    return std::max(least_memory, std::min(share, machine_memory("MemAvailable:")));
}

}  // namespace lamella::cli::batch
