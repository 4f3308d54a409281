// Runs arranged for the search for those whose boxes come near one another: by upright strips of the layer, each of which
// holds the runs that reach into it, from the lowest up.
//
//      |  ____   |
//      | /   |\  |         four runs; the upper two reach into two strips each
//      |/    | \ |
//      |\    | / |
//      | \___|/  |
//      |     |   |
//
// Boxes are grown by the margin to the right and upwards: two that meet then are no farther apart than the margin.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/array.hpp"
#include "slicing/edges/edge_runs.hpp"
#include "slicing/edges/run_kernels.hpp"
#include "slicing/nesting/order.hpp"

namespace lamella {

/// The strips of one layer after another; its memory is kept.
class RunStrips {
public:
    explicit RunStrips(Worker& worker) noexcept : worker_(worker) {}

    /// O(r) for many runs. `margin` is below grid_limit. `parallel`: a few calls of run() for many runs, which give the same
    /// strips on any number of threads; null: on this thread. Throws std::bad_alloc.
    void assign(std::span<const EdgeRun> runs, std::int32_t margin, const Parallel* parallel = nullptr);
    void assign(std::span<const EdgeRun> runs, std::int32_t margin, const Parallel& parallel) {
        assign(runs, margin, &parallel);
    }

    std::int32_t margin() const noexcept { return margin_; }
    std::size_t count() const noexcept { return firsts_.empty() ? 0 : firsts_.size() - 1; }
    /// Where a strip begins.
    std::int32_t left_of(std::size_t strip) const noexcept {
        return static_cast<std::int32_t>(low_ + (static_cast<std::int64_t>(strip) << shift_));
    }
    /// The entries of a strip: [first, second), as indices into boxes(), ordered by low_y.
    std::pair<std::size_t, std::size_t> entries_of(std::size_t strip) const noexcept {
        return {firsts_[strip], firsts_[strip + 1]};
    }
    /// Cuts the strips into `shares` that hold about as much each: where one begins.
    std::size_t first_strip_of(std::size_t share, std::size_t shares) const noexcept;

    BoxArrays boxes() const noexcept {
        return {low_x_.data(), low_y_.data(), high_x_.data(), high_y_.data(), run_at_.data()};
    }

private:
    std::size_t strip_of(std::int64_t x) const noexcept { return static_cast<std::size_t>((x - low_) >> shift_); }
    nesting::SortKey key_of(std::size_t run) const noexcept;
    void choose_strips();
    template <class Work>
    void each_entry(std::size_t begin, std::size_t end, std::size_t* cursors, const Work& work) const;
    std::size_t count_to_cursors(std::size_t ranges) noexcept;
    void make_entries(std::size_t count);
    void write_entry(std::size_t at, std::uint32_t run) noexcept;

    Worker& worker_;
    std::span<const EdgeRun> runs_;
    std::int32_t margin_ = 0;
    Vector<nesting::SortKey> order_{worker_.memory()};  // of runs by low.y
    Vector<nesting::SortKey> spare_{worker_.memory()};
    std::int64_t low_ = 0;
    int shift_ = 0;
    Vector<std::size_t> firsts_{worker_.memory()};  // of each strip, and the end of the last
    Vector<std::size_t> cursors_{
        worker_.memory()};  // by range of runs and strip: first a count, then where the next run goes
    Array<std::int32_t> low_x_{worker_.memory()};
    Array<std::int32_t> low_y_{worker_.memory()};
    Array<std::int32_t> high_x_{worker_.memory()};
    Array<std::int32_t> high_y_{worker_.memory()};
    Array<std::uint32_t> run_at_{worker_.memory()};
};

}  // namespace lamella
