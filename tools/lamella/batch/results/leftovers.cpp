#include "batch/results/leftovers.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>
#include <system_error>
#include <thread>

#include <unistd.h>

namespace lamella::cli::batch {

namespace {

constexpr std::size_t longest_stem = 180;  ///< of a target in the name of its file aside: io/write/output_file.cpp

bool is_digits(std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

struct AsideName {
    std::string target;
    std::string process;
};

/// Of ".NAME.PID-TIME.part"; the target is empty for any other name.
AsideName parse_aside(const std::string& name) {
    constexpr std::string_view end = ".part";
    std::string_view rest = name;
    if (!rest.starts_with('.') || !rest.ends_with(end) || rest.size() <= end.size() + 1) {
        return {};
    }
    rest = rest.substr(1, rest.size() - 1 - end.size());
    const std::size_t dot = rest.rfind('.');
    const std::size_t dash = rest.rfind('-');
    if (dot == std::string_view::npos || dash == std::string_view::npos || dash < dot ||
        !is_digits(rest.substr(dot + 1, dash - dot - 1)) || !is_digits(rest.substr(dash + 1))) {
        return {};
    }
    return {std::string(rest.substr(0, dot)), std::string(rest.substr(dot + 1, dash - dot - 1))};
}

/// Whether another process of this number runs this program.
bool runs_here(const std::string& process) {
    if (process == std::to_string(::getpid())) {
        return false;
    }
    std::error_code unknown;
    const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", unknown);
    const std::filesystem::path other = std::filesystem::read_symlink("/proc/" + process + "/exe", unknown);
    return !unknown && own == other;
}

void remove_unless_written(const std::filesystem::path& path, const std::string& process,
                           std::chrono::steady_clock::time_point until) {
    // A process that is being killed is still listed for a moment.
    while (runs_here(process)) {
        if (std::chrono::steady_clock::now() >= until) {
            return;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
}

}  // namespace

void remove_leftovers(const std::vector<std::string>& targets, std::chrono::milliseconds patience) {
    std::map<std::filesystem::path, std::set<std::string>> names;
    for (const std::string& target : targets) {
        const std::filesystem::path path(target);
        names[path.has_parent_path() ? path.parent_path() : "."].insert(path.filename().string().substr(0, longest_stem));
    }
    const auto until = std::chrono::steady_clock::now() + patience;
    for (const auto& [folder, wanted] : names) {
        std::vector<std::filesystem::path> found;
        std::error_code problem;
        for (std::filesystem::directory_iterator at(folder, problem);
             !problem && at != std::filesystem::directory_iterator(); at.increment(problem)) {
            found.push_back(at->path());
        }
        for (const std::filesystem::path& path : found) {
            const AsideName aside = parse_aside(path.filename().string());
            if (!aside.target.empty() && wanted.contains(aside.target)) {
                remove_unless_written(path, aside.process, until);
            }
        }
    }
}

}  // namespace lamella::cli::batch
