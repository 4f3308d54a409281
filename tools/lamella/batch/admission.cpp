#include "batch/admission.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <sched.h>

#include "files/mesh_input.hpp"
#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli::batch {

namespace {

constexpr double several_threads_from = 3e6;  ///< triangles: below, a second thread earns less than another mesh would

/// The folders of this process's control group and of those above it, for a controller of version 1 or for all ("").
std::vector<std::string> group_folders(const std::string& controller) {
    std::ifstream file("/proc/self/cgroup");
    std::string group;
    for (std::string line; std::getline(file, line);) {  // "9:memory:/user.slice", or "0::/user.slice" for all
        const std::size_t first = line.find(':');
        const std::size_t second = line.find(':', first + 1);
        if (second != std::string::npos && line.substr(first + 1, second - first - 1) == controller) {
            group = line.substr(second + 1);
        }
    }
    std::vector<std::string> folders;
    while (true) {
        folders.push_back(std::string("/sys/fs/cgroup/").append(controller).append(group).append("/"));
        const std::size_t slash = group.rfind('/');
        if (slash == std::string::npos) {
            return folders;
        }
        group.resize(slash);
    }
}

/// The limit is a number, or "max".
double group_memory() {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [controller, name] : {std::pair{"", "memory.max"}, {"memory", "memory.limit_in_bytes"}}) {
        for (const std::string& folder : group_folders(controller)) {
            std::ifstream file(folder + name);
            std::string limit;
            file >> limit;
            least = std::min(least, parse_number(limit).value_or(least));
        }
    }
    return least;
}

/// "200000 100000" in cpu.max: two processors.
int group_threads() {
    double least = std::numeric_limits<int>::max();
    for (const std::string& folder : group_folders("")) {
        std::ifstream file(folder + "cpu.max");
        std::string quota;
        double period = 0;
        if (file >> quota >> period && period > 0) {
            least = std::min(least, parse_number(quota).value_or(least * period) / period);
        }
    }
    return static_cast<int>(std::max(1.0, std::ceil(least)));
}

/// A line of /proc/meminfo, in bytes.
double machine_memory(std::string_view key) {
    const std::optional<std::uint64_t> kilobytes = system_number("/proc/meminfo", key);
    return kilobytes ? static_cast<double>(*kilobytes) * 1024 : std::numeric_limits<double>::infinity();
}

struct FormatCost {
    std::string_view end;     ///< of the name
    std::string_view marker;  ///< in the first bytes; empty: any
    double file_bytes;        ///< a triangle
    double memory_bytes;      ///< a triangle
};

/// The first row that fits holds. Rows are the largest of what was measured, so that packed STL counts as text. XML
/// polydata without compression may have 32-bit indices, which take fewer bytes of file than the 64-bit ones measured.
constexpr std::array<FormatCost, 18> costs = {{
    {".stl.gz", "", 17, 320},
    {".ply.gz", "", 9, 140},
    {".obj.gz", "", 11, 140},
    {".off.gz", "", 11, 140},
    {".vtk.gz", "", 10, 145},
    {".vtp.gz", "", 11, 170},
    {".gz", "", 9, 200},
    {".stl", "", 50, 145},
    {".obj", "", 36, 130},
    {".off", "", 36, 130},
    {".ply", "format ascii", 36, 125},
    {".ply", "", 19, 135},
    {".vtk", "ASCII", 36, 125},
    {".vtk", "", 22, 140},
    {".vtp", "compressor=", 10, 125},
    {".vtp", "", 22, 150},
    {".3mf", "", 14, 155},
    {"", "", 20, 200},
}};
constexpr FormatCost text_stl = {".stl", "", 150, 190};

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

/// The triangles that the header states fill the file.
bool is_binary_stl(const std::string& begin, std::uint64_t file_bytes) {
    constexpr std::size_t header = 84;
    std::uint32_t triangles = 0;
    if (begin.size() < header) {
        return false;
    }
    std::memcpy(&triangles, begin.data() + 80, sizeof triangles);
    return file_bytes >= header + std::uint64_t{50} * triangles && !(begin.starts_with("solid") && triangles == 0);
}

FormatCost cost_of(const std::string& name, const std::string& begin, std::uint64_t file_bytes) {
    const FormatCost cost = *std::find_if(costs.begin(), costs.end(), [&](const FormatCost& row) {
        return name.ends_with(row.end) && begin.find(row.marker) != std::string::npos;
    });
    return cost.end == ".stl" && !is_binary_stl(begin, file_bytes) ? text_stl : cost;
}

}  // namespace

int usable_threads() {
    cpu_set_t set;
    CPU_ZERO(&set);
    const int own = ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return std::max(1, std::min(own, group_threads()));
}

std::uint64_t usable_memory() {
    constexpr double least = 32 << 20;
    constexpr double most = 1e18;  // where no limit is known
    const double all = std::min(machine_memory("MemTotal:"), group_memory());
    return static_cast<std::uint64_t>(std::clamp(std::min(all / 4 * 3, machine_memory("MemAvailable:")), least, most));
}

MeshEstimate estimate_mesh(const std::string& path, std::uint64_t file_bytes) {
    const FormatCost cost = cost_of(lower_case(path), first_bytes(path), file_bytes);
    const double triangles = static_cast<double>(file_bytes) / cost.file_bytes;
    return {triangles, process_bytes + triangles * cost.memory_bytes};
}

void Admission::add(std::size_t item, const MeshEstimate& estimate, int threads) {
    if (entries_.size() <= item) {
        entries_.resize(item + 1);
    }
    entries_[item].estimate = estimate;
    entries_[item].asked = threads;
    waiting_.push_back(item);
}

void Admission::sort() {
    std::stable_sort(waiting_.begin(), waiting_.end(), [this](std::size_t a, std::size_t b) {
        return entries_[a].estimate.bytes > entries_[b].estimate.bytes;
    });
}

void Admission::add_again(std::size_t item, bool alone) {
    entries_[item].alone = alone;
    waiting_.push_back(item);
}

double Admission::need_of(std::size_t item) const {
    const MeshEstimate& estimate = entries_[item].estimate;
    return process_bytes + (estimate.bytes - process_bytes) * factor_;
}

bool Admission::fits(const Entry& entry, double need) const {
    if (running_ == 0) {
        return true;
    }
    return !alone_runs_ && !entry.alone && used_threads_ < jobs_ && used_bytes_ + need <= memory_;
}

/// All that are left where only few such meshes are left or fit into memory at once; else one for a small mesh.
int Admission::threads_for(const Entry& entry, double need) const {
    if (entry.asked > 0) {
        return entry.asked;
    }
    const int left = jobs_ - used_threads_;
    if (entry.alone || need > memory_) {
        return left;
    }
    const auto at_once = static_cast<int>(std::min<double>(jobs_, memory_ / need));
    const int beside = std::max(1, std::min(at_once, static_cast<int>(std::min<std::size_t>(
                                                         running_ + waiting_.size(), static_cast<std::size_t>(jobs_)))));
    const int share = std::max(1, jobs_ / beside);
    const int by_size = entry.estimate.triangles >= several_threads_from ? share : std::min(share, 2);
    return std::clamp(by_size, 1, left);
}

std::optional<Admitted> Admission::next() {
    for (auto at = waiting_.begin(); at != waiting_.end(); ++at) {
        Entry& entry = entries_[*at];
        const double need = need_of(*at);
        if (!fits(entry, need)) {
            continue;
        }
        const bool alone = entry.alone || need > memory_;
        const Admitted admitted{*at, threads_for(entry, need), alone};
        entry.threads = admitted.threads;
        entry.bytes = need;
        used_threads_ += entry.threads;
        used_bytes_ += need;
        ++running_;
        alone_runs_ = alone;
        waiting_.erase(at);
        return admitted;
    }
    return std::nullopt;
}

void Admission::ended(std::size_t item, std::uint64_t peak_bytes) {
    const Entry& entry = entries_[item];
    used_threads_ -= entry.threads;
    used_bytes_ -= entry.bytes;
    --running_;
    alone_runs_ = false;
    constexpr double worth_learning = 64e6;
    const double over = static_cast<double>(peak_bytes) - process_bytes;
    if (over > worth_learning && !entry.alone) {
        constexpr double most = 8;
        factor_ = std::clamp(over / std::max(worth_learning / most, entry.estimate.bytes - process_bytes), factor_, most);
    }
}

}  // namespace lamella::cli::batch
