#include <sched.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>

#include "measure.hpp"

namespace lamella::bench {

namespace {

/// The text after the colon in the first line of `file` that begins with `key`.
std::string value_in(const char* file, std::string_view key) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        const std::size_t colon = line.find(": ");
        if (line.starts_with(key) && colon != std::string::npos) {
            return line.substr(std::min(line.find_first_not_of(' ', colon + 1), line.size()));
        }
    }
    return "unknown";
}

/// The setting of transparent huge pages, such as "always [madvise] never".
std::string huge_pages() {
    std::ifstream in("/sys/kernel/mm/transparent_hugepage/enabled");
    std::string setting;
    return std::getline(in, setting) ? setting : "unknown";
}

void append_item(const std::string& item, std::string& list) {
    if (!list.empty()) {
        list += ',';
    }
    list += item;
}

std::string allowed_cores() {
    cpu_set_t set;
    CPU_ZERO(&set);
    std::string cores;
    if (sched_getaffinity(0, sizeof set, &set) != 0) {
        return "unknown";
    }
    for (std::size_t core = 0; core < CPU_SETSIZE; ++core) {
        if (CPU_ISSET(core, &set)) {
            append_item(std::to_string(core), cores);
        }
    }
    return cores;
}

}  // namespace

void describe_context(const Options& options) {
    std::string threads;
    for (const int count : thread_counts(options)) {
        append_item(std::to_string(count), threads);
    }
    benchmark::AddCustomContext("processor", value_in("/proc/cpuinfo", "model name"));
    benchmark::AddCustomContext("memory", value_in("/proc/meminfo", "MemTotal"));
    benchmark::AddCustomContext("compiler", LAMELLA_BENCH_COMPILER);
    benchmark::AddCustomContext("flags", LAMELLA_BENCH_FLAGS);
    benchmark::AddCustomContext("thread_counts", threads);
    benchmark::AddCustomContext("pinning", "process on cores " + allowed_cores() + ", threads not pinned one by one");
    benchmark::AddCustomContext("transparent_huge_pages", huge_pages());
#ifdef LAMELLA_BENCH_MIMALLOC
    benchmark::AddCustomContext("allocator", "mimalloc");
#else
    benchmark::AddCustomContext("allocator", "the system's");
#endif
    benchmark::AddCustomContext("sizes", options.quick ? "quick: a hundredth; figures mean nothing" : "full");
}

}  // namespace lamella::bench
