// Which item starts next, and with how many threads: the largest first, as long as threads and memory last. For that, what
// the machine grants this process, and how much of it slicing a file takes.
//
// Peak resident sizes by format were measured with bench/scripts/batch_memory.py; bench/README.md has the table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace lamella::cli::batch {

/// Processors: the lesser of what the machine has and what this process's control group grants.
int usable_threads();

/// Three quarters of the memory that they have, or what is free if that is less.
std::uint64_t usable_memory();

struct MeshEstimate {
    double triangles = 0;
    double bytes = 0;  ///< of memory
};

inline constexpr double process_bytes = 16e6;  ///< that slicing the smallest mesh takes

/// Looks at the file's first bytes and its size; O(1). A file that cannot be read is estimated as empty.
MeshEstimate estimate_mesh(const std::string& path, std::uint64_t file_bytes);

struct Admitted {
    std::size_t item = 0;
    int threads = 1;
    bool alone = false;  ///< nothing runs beside it: it may need more than all of the memory
};

/// Memory is that of the estimates, times how far the worst mesh so far went beyond its own.
class Admission {
public:
    Admission(int jobs, std::uint64_t memory_bytes) : jobs_(jobs), memory_(static_cast<double>(memory_bytes)) {}

    /// `threads`: asked for; 0: as many as serve.
    void add(std::size_t item, const MeshEstimate& estimate, int threads);
    /// All that were added, the largest first.
    void sort();
    /// Once more, after all others; `alone`: with nothing beside it.
    void add_again(std::size_t item, bool alone);

    /// None while nothing fits beside what runs.
    std::optional<Admitted> next();
    void ended(std::size_t item, std::uint64_t peak_bytes);

    /// True if the item takes more than all of the memory.
    bool is_too_large(std::size_t item) const { return need_of(item) > memory_; }
    double need_of(std::size_t item) const;

private:
    struct Entry {
        MeshEstimate estimate;
        int asked = 0;
        bool alone = false;
        int threads = 0;   ///< while it runs
        double bytes = 0;  ///< while it runs
    };

    int threads_for(const Entry& entry, double need) const;
    bool fits(const Entry& entry, double need) const;

    int jobs_;
    double memory_;
    double factor_ = 1;
    int used_threads_ = 0;
    double used_bytes_ = 0;
    std::size_t running_ = 0;
    bool alone_runs_ = false;
    std::vector<Entry> entries_;  ///< by item
    std::vector<std::size_t> waiting_;
};

}  // namespace lamella::cli::batch
