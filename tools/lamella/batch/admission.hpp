// Which item starts next, and with how many threads: the largest first, as long as threads and memory last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "batch/resources.hpp"

namespace lamella::cli::batch {

struct Admitted {
    std::size_t item = 0;
    int threads = 1;
    bool alone = false;  ///< nothing runs beside it: it may need more than all of the memory
};

/// Memory is that of the estimates, times how far the worst mesh so far went beyond its own.
class Admission {
public:
    Admission(int jobs, std::uint64_t memory_bytes) : jobs_(jobs), memory_(static_cast<double>(memory_bytes)) {}

    void add(std::size_t item, const MeshEstimate& estimate, std::optional<int> threads);
    /// All that were added, the largest first.
    void sort();
    /// Once more, after all others; `alone`: with nothing beside it.
    void add_again(std::size_t item, bool alone);

    /// None while nothing fits beside what runs.
    std::optional<Admitted> next();
    void ended(std::size_t item, std::uint64_t peak_bytes);

    bool empty() const noexcept { return waiting_.empty(); }
    /// Whether the item takes more than all of the memory.
    bool is_too_large(std::size_t item) const { return need_of(item) > memory_; }
    double need_of(std::size_t item) const;
    double triangles_of(std::size_t item) const { return entries_[item].estimate.triangles; }

private:
    struct Entry {
        MeshEstimate estimate;
        std::optional<int> asked;
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
