#include "batch/machine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>
#include <system_error>

#include <sched.h>

#include "files/flags.hpp"
#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli::batch {

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

/// The least limit that `limit_in` reads from a file of this name in the control groups of this process, its own and those
/// above it. `controller`: of version 1, or "" for all of version 2.
double group_limit(const std::string& controller, const std::string& name,
                   const std::function<double(std::istream&)>& limit_in) {
    std::ifstream groups("/proc/self/cgroup");
    double least = no_limit;
    for (std::string line; std::getline(groups, line);) {  // "9:memory:/user.slice", or "0::/user.slice" for all
        const std::size_t middle = line.find(':' + controller + ":/");
        if (middle == std::string::npos) {
            continue;
        }
        std::filesystem::path group = line.substr(middle + controller.size() + 3);
        const std::filesystem::path top = std::filesystem::path("/sys/fs/cgroup") / controller;
        for (bool more = true; more; group = group.parent_path()) {
            more = !group.empty();
            std::ifstream file(top / group / name);
            least = std::min(least, limit_in(file));
        }
    }
    return least;
}

/// A number, or "max".
double memory_in(std::istream& file) {
    std::string limit;
    file >> limit;
    return parse_number(limit).value_or(no_limit);
}

/// "200000 100000" in cpu.max: two processors.
double threads_in(std::istream& file) {
    std::string quota;
    double period = 0;
    file >> quota >> period;
    return period > 0 ? parse_number(quota).value_or(no_limit) / period : no_limit;
}

/// A line of /proc/meminfo, in bytes.
double machine_memory(std::string_view key) {
    const std::optional<std::uint64_t> kilobytes = system_number("/proc/meminfo", key);
    return kilobytes ? static_cast<double>(*kilobytes) * 1024 : no_limit;
}

struct FormatCost {
    std::string_view end;     ///< of the name
    std::string_view marker;  ///< in the first bytes; empty: any
    double memory;            ///< bytes, for each byte of the file
};

/// The first row that fits holds. Each is the largest of what was measured.
constexpr std::array<FormatCost, 14> costs = {{
    {".stl.gz", "", 19},
    {".gz", "", 22},
    {".stl", "facet", 1.3},
    {".stl", "", 2.9},
    {".obj", "", 3.7},
    {".off", "", 3.7},
    {".ply", "format ascii", 3.5},
    {".ply", "", 7.2},
    {".vtk", "ASCII", 3.5},
    {".vtk", "", 6.4},
    {".vtp", "compressor=", 12.5},
    {".vtp", "", 6.9},
    {".3mf", "", 11.1},
    {"", "", 10},
}};

/// None if it is no file, as a pipe could keep the batch waiting.
std::string first_bytes(const std::string& path) {
    std::error_code unknown;
    std::string bytes(512, '\0');
    std::ifstream file;
    if (std::filesystem::is_regular_file(path, unknown)) {
        file.open(path, std::ios::binary);
    }
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(file.gcount()));
    return bytes;
}

}  // namespace

int usable_threads() {
    cpu_set_t set;
    CPU_ZERO(&set);
    const int own = ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return static_cast<int>(std::max(1.0, std::min<double>(own, std::ceil(group_limit("", "cpu.max", threads_in)))));
}

std::uint64_t usable_memory() {
    constexpr double least = 32 << 20;
    constexpr double most = 1e18;  // where no limit is known
    const double group =
        std::min(group_limit("", "memory.max", memory_in), group_limit("memory", "memory.limit_in_bytes", memory_in));
    const double all = std::min(machine_memory("MemTotal:"), group);
    return static_cast<std::uint64_t>(std::clamp(std::min(all / 4 * 3, machine_memory("MemAvailable:")), least, most));
}

double estimate_memory(const std::string& path, std::uint64_t file_bytes) {
    const std::string name = lower_case(path);
    const std::string begin = first_bytes(path);
    const auto* const cost = std::find_if(costs.begin(), costs.end(), [&](const FormatCost& row) {
        return name.ends_with(row.end) && begin.find(row.marker) != std::string::npos;
    });
    return process_bytes + static_cast<double>(file_bytes) * cost->memory;
}

}  // namespace lamella::cli::batch
