#include "audit/edge_runs.hpp"

#include <algorithm>
#include <bit>
#include <functional>
#include <limits>
#include <new>
#include <span>

#include "base/parallel_sort.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_edges_of_piece = std::size_t{1} << 16;
constexpr std::size_t runs_of_range = std::size_t{1} << 15;
constexpr std::size_t most_ranges = 16;
constexpr std::size_t few_runs = std::size_t{1} << 16;  ///< are ordered on one thread
constexpr std::int64_t runs_of_strip = 8;

/// Leaves the contents unspecified; memory grows by half, so that layers of many sizes take it only a few times.
template <class T>
void make_room(Array<T>& array, std::size_t count) {
    if (count > array.capacity()) {
        array.resize_discarding(count + count / 2);
    }
    array.set_size(count);
}

}  // namespace

void EdgeRuns::assign(const SliceResult& result, const Layer& layer, const Parallel& parallel) {
    list_pieces(result, layer);
    const std::size_t tasks = tasks_.size() - 1;
    scratch_.resize(std::max(scratch_.size(), tasks));
    const auto for_each_piece = [&](const auto& work) {
        parallel.run(tasks, [&](std::size_t task, int) {
            scratch_[task].runs.clear();
            for (std::size_t p = tasks_[task]; p < tasks_[task + 1]; ++p) {
                work(pieces_[p], scratch_[task]);
            }
        });
    };
    for_each_piece([&](const Piece& piece, Scratch&) { copy_points(result, piece); });
    for_each_piece([&](const Piece& piece, Scratch& scratch) { cut(piece, scratch); });
    join_runs(parallel);
    order_runs(parallel);
    choose_strips();
    fill_strips(parallel);
}

void EdgeRuns::list_pieces(const SliceResult& result, const Layer& layer) {
    paths_.clear();
    pieces_.clear();
    tasks_.assign(1, 0);
    edges_ = 0;
    std::size_t points = 0;
    std::size_t edges_of_task = 0;
    for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
        const Contour& contour = result.contours[c];
        const bool closed = contour.role != Role::open;
        const std::size_t count = contour.point_count;
        if (count < 2) {
            continue;
        }
        const std::size_t edges = closed ? count : count - 1;
        for (std::size_t begin = 0; begin < edges; begin += most_edges_of_piece) {
            const std::size_t end = std::min(edges, begin + most_edges_of_piece);
            pieces_.push_back({static_cast<std::uint32_t>(paths_.size()), points + begin, points + end});
            edges_of_task += end - begin;
            if (edges_of_task >= most_edges_of_piece) {
                tasks_.push_back(pieces_.size());
                edges_of_task = 0;
            }
        }
        paths_.push_back({points, points + edges, c, closed});
        points += edges + 2;
        edges_ += edges;
    }
    if (tasks_.back() != pieces_.size()) {
        tasks_.push_back(pieces_.size());
    }
    make_room(points_, points);
}

/// The last piece of a path also copies the two points after it; an open path has one.
void EdgeRuns::copy_points(const SliceResult& result, const Piece& piece) {
    const LayerPath& path = paths_[piece.path];
    const Contour& contour = result.contours[path.contour];
    const Point* const from = result.points.data() + contour.first_point;
    std::copy(from + (piece.begin - path.begin), from + (piece.end - path.begin), points_.data() + piece.begin);
    if (piece.end == path.end) {
        points_[path.end] = path.closed ? from[0] : from[contour.point_count - 1];
        points_[path.end + 1] = from[path.closed ? 1 : 0];
    }
}

void EdgeRuns::cut(const Piece& piece, Scratch& scratch) const {
    const std::size_t edges = piece.end - piece.begin;
    scratch.turns.resize(std::max(scratch.turns.size(), edges));
    const Point* const points = points_.data();
    const std::size_t turns = best_of(run_kernel_forms()).find_turns(points + piece.begin, edges, scratch.turns.data());
    std::size_t begin = piece.begin;
    for (std::size_t i = 0; i <= turns; ++i) {
        const std::size_t end = i == turns ? piece.end : piece.begin + scratch.turns[i];
        scratch.runs.push_back({FlatBox::around(points[begin], points[end]), begin, end, piece.path});
        begin = end;
    }
}

void EdgeRuns::join_runs(const Parallel& parallel) {
    const std::size_t tasks = tasks_.size() - 1;
    std::size_t count = 0;
    for (std::size_t task = 0; task < tasks; ++task) {
        count += scratch_[task].runs.size();
    }
    if (count > std::numeric_limits<std::uint32_t>::max()) {
        throw std::bad_alloc();
    }
    make_room(runs_, count);
    parallel.run(tasks, [&](std::size_t task, int) {
        std::size_t first = 0;
        for (std::size_t before = 0; before < task; ++before) {
            first += scratch_[before].runs.size();
        }
        std::copy(scratch_[task].runs.begin(), scratch_[task].runs.end(), runs_.data() + first);
    });
}

void EdgeRuns::order_runs(const Parallel& parallel) {
    order_.resize(runs_.size());
    const auto key = [&](std::size_t run) {
        const std::uint32_t low_y = static_cast<std::uint32_t>(runs_[run].box.low.y) ^ 0x80000000U;
        return std::uint64_t{low_y} << 32 | run;
    };
    if (runs_.size() <= few_runs) {
        unordered_.resize(runs_.size());
        for (std::size_t r = 0; r < runs_.size(); ++r) {
            unordered_[r] = key(r);
        }
        order_few();
        return;
    }
    parallel.run_ranges(runs_.size(), runs_of_range, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t r = begin; r < end; ++r) {
            order_[r] = key(r);
        }
    });
    sort_in_parallel(std::span<std::uint64_t>(order_), std::less<>(), parallel);
}

/// Into about as many buckets as there are runs, of which only those with several are sorted.
void EdgeRuns::order_few() {
    if (unordered_.empty()) {
        return;
    }
    const auto [lowest, highest] = std::minmax_element(unordered_.begin(), unordered_.end());
    const std::uint64_t low = *lowest;
    const int shift =
        std::max(0, static_cast<int>(std::bit_width(*highest - low)) - static_cast<int>(std::bit_width(unordered_.size())));
    const auto bucket_of = [&](std::uint64_t key) { return static_cast<std::size_t>((key - low) >> shift); };
    places_.assign(bucket_of(*highest) + 1, 0);
    for (const std::uint64_t key : unordered_) {
        ++places_[bucket_of(key)];
    }
    std::uint32_t sum = 0;
    for (std::uint32_t& place : places_) {
        sum += std::exchange(place, sum);
    }
    for (const std::uint64_t key : unordered_) {
        order_[places_[bucket_of(key)]++] = key;  // which then is where the next bucket begins
    }
    std::uint32_t begin = 0;
    for (const std::uint32_t end : places_) {
        if (end > begin + 1) {
            std::sort(order_.begin() + begin, order_.begin() + end);
        }
        begin = end;
    }
}

/// About twice as wide as runs are on average, so that few reach into many.
void EdgeRuns::choose_strips() {
    firsts_.clear();
    if (runs_.empty()) {
        return;
    }
    std::int32_t low = runs_[0].box.low.x;
    std::int32_t high = runs_[0].box.high.x;
    std::int64_t widths = 0;
    for (const EdgeRun& run : runs_) {
        low = std::min(low, run.box.low.x);
        high = std::max(high, run.box.high.x);
        widths += std::int64_t{run.box.high.x} - run.box.low.x;
    }
    low_ = low;
    const std::int64_t all = std::int64_t{high} - low;
    const auto runs = static_cast<std::int64_t>(runs_.size());
    shift_ = 0;
    while (((all >> shift_) > runs / runs_of_strip || (std::int64_t{1} << shift_) * runs < 2 * widths) && shift_ < 32) {
        ++shift_;
    }
    firsts_.assign(static_cast<std::size_t>(all >> shift_) + 2, 0);
}

void EdgeRuns::fill_strips(const Parallel& parallel) {
    const std::size_t ranges = std::clamp<std::size_t>(runs_.size() / runs_of_range, 1, most_ranges);
    cursors_.assign(ranges * strips(), 0);
    const auto for_each_entry = [&](const auto& work) {
        parallel.run(ranges, [&](std::size_t range, int) {
            std::size_t* const own = cursors_.data() + range * strips();
            for (std::size_t i = runs_.size() * range / ranges; i < runs_.size() * (range + 1) / ranges; ++i) {
                const auto r = static_cast<std::uint32_t>(order_[i]);
                const FlatBox& box = runs_[r].box;
                const std::size_t last = strip_of(box.high.x);
                for (std::size_t s = strip_of(box.low.x); s <= last; ++s) {
                    work(own[s]++, box, r);
                }
            }
        });
    };
    for_each_entry([](std::size_t, const FlatBox&, std::uint32_t) {});
    std::size_t sum = 0;
    for (std::size_t s = 0; s < strips(); ++s) {
        firsts_[s] = sum;
        for (std::size_t range = 0; range < ranges; ++range) {
            sum += std::exchange(cursors_[range * strips() + s], sum);
        }
    }
    if (!firsts_.empty()) {
        firsts_.back() = sum;
    }
    for (Array<std::int32_t>* numbers : {&low_x_, &low_y_, &high_x_, &high_y_}) {
        make_room(*numbers, sum + run_lanes);
    }
    make_room(run_at_, sum + run_lanes);
    for_each_entry([&](std::size_t at, const FlatBox& box, std::uint32_t run) {
        low_x_[at] = box.low.x;
        low_y_[at] = box.low.y;
        high_x_[at] = box.high.x;
        high_y_[at] = box.high.y;
        run_at_[at] = run;
    });
}

std::size_t EdgeRuns::first_strip_of(std::size_t share, std::size_t shares) const noexcept {
    if (firsts_.empty()) {
        return 0;
    }
    const std::size_t entries = firsts_.back() * share / shares;
    return share == shares
               ? strips()
               : static_cast<std::size_t>(std::lower_bound(firsts_.begin(), firsts_.end() - 1, entries) - firsts_.begin());
}

}  // namespace lamella
