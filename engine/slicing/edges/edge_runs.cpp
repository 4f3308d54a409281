#include "slicing/edges/edge_runs.hpp"

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include "base/numbers.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_edges_of_piece = std::size_t{1} << 16;

/// Keeps the first `kept` elements and leaves the others unspecified; memory grows by half, so that layers of many sizes
/// take it only a few times.
template <class T>
void resize_keeping(Array<T>& array, std::size_t kept, std::size_t count) {
    if (count > array.capacity()) {
        Array<T> larger(array.memory());
        larger.resize_discarding(count + count / 2);
        std::copy(array.begin(), array.begin() + kept, larger.begin());
        array = std::move(larger);
    }
    array.set_size(count);
}

}  // namespace

void EdgeRuns::clear() noexcept {
    paths_.clear();
    edges_ = 0;
    point_count_ = 0;
    runs_.set_size(0);
}

void EdgeRuns::list(const EdgePath& path) {
    if (paths_.size() == std::numeric_limits<std::uint32_t>::max()) {
        throw std::bad_alloc();
    }
    EdgePath& listed = paths_.emplace_back(path);
    listed.begin = point_count_;
    listed.end = point_count_ + path.edges();
    edges_ += path.edges();
    point_count_ += path.edges() + 2;
}

void EdgeRuns::add(const EdgePath& path) {
    if (path.edges() == 0) {
        return;
    }
    const std::size_t points_before = point_count_;
    list(path);
    resize_keeping(points_, points_before, point_count_ + turn_lanes);
    const Piece whole{static_cast<std::uint32_t>(paths_.size() - 1), paths_.back().begin, paths_.back().end};
    copy_points(whole);
    const std::size_t turns = find_turns(whole, turns_);
    const std::size_t runs_before = runs_.size();
    if (runs_before + turns >= std::numeric_limits<std::uint32_t>::max()) {
        throw std::bad_alloc();
    }
    resize_keeping(runs_, runs_before, runs_before + turns + 1);
    write_runs(whole, {turns_.data(), turns}, runs_.data() + runs_before);
}

void EdgeRuns::assign(std::span<const EdgePath> paths, const Parallel& parallel) {
    clear();
    for (const EdgePath& path : paths) {
        if (path.edges() > 0) {
            list(path);
        }
    }
    list_pieces();
    resize_keeping(points_, 0, point_count_ + turn_lanes);
    const std::size_t tasks = tasks_.size() - 1;
    const auto each_piece = [&](const auto& work) {
        parallel.run(tasks, [&](std::size_t task, int) {
            for (std::size_t p = tasks_[task]; p < tasks_[task + 1]; ++p) {
                work(task, p);
            }
        });
    };
    each_piece([&](std::size_t, std::size_t p) { copy_points(pieces_[p]); });
    runs_of_pieces_.assign(pieces_.size(), 0);
    turns_of_tasks_.assign(tasks, Vector<std::uint32_t>(turns_.get_allocator()));
    parallel.run(tasks, [&](std::size_t task, int) {
        Vector<std::uint32_t> turns(turns_.get_allocator());
        Vector<std::uint32_t>& own = turns_of_tasks_[task];
        for (std::size_t p = tasks_[task]; p < tasks_[task + 1]; ++p) {
            const std::size_t count = find_turns(pieces_[p], turns);
            own.insert(own.end(), turns.begin(), turns.begin() + static_cast<std::ptrdiff_t>(count));
            runs_of_pieces_[p] = count + 1;
        }
    });
    std::size_t count = 0;
    for (std::size_t& runs : runs_of_pieces_) {
        count += std::exchange(runs, count);
    }
    if (count > std::numeric_limits<std::uint32_t>::max()) {
        throw std::bad_alloc();
    }
    runs_of_pieces_.push_back(count);
    resize_keeping(runs_, 0, count);
    parallel.run(tasks, [&](std::size_t task, int) {
        const std::uint32_t* turns = turns_of_tasks_[task].data();
        for (std::size_t p = tasks_[task]; p < tasks_[task + 1]; ++p) {
            const std::size_t own = runs_of_pieces_[p + 1] - runs_of_pieces_[p] - 1;
            write_runs(pieces_[p], {turns, own}, runs_.data() + runs_of_pieces_[p]);
            turns += own;
        }
    });
}

void EdgeRuns::list_pieces() {
    pieces_.clear();
    tasks_.assign(1, 0);
    std::size_t edges_of_task = 0;
    for (std::uint32_t path = 0; path < paths_.size(); ++path) {
        for (std::size_t begin = paths_[path].begin; begin < paths_[path].end; begin += most_edges_of_piece) {
            const std::size_t end = std::min(paths_[path].end, begin + most_edges_of_piece);
            pieces_.push_back({path, begin, end});
            edges_of_task += end - begin;
            if (edges_of_task >= most_edges_of_piece) {
                tasks_.push_back(pieces_.size());
                edges_of_task = 0;
            }
        }
    }
    if (tasks_.back() != pieces_.size()) {
        tasks_.push_back(pieces_.size());
    }
}

/// The last piece of a path also copies the two points after it; an open path has one.
void EdgeRuns::copy_points(const Piece& piece) noexcept {
    const EdgePath& path = paths_[piece.path];
    const std::size_t first = piece.begin - path.begin + path.start;
    const std::size_t end = piece.end - path.begin + path.start;
    const std::size_t count = path.points.size();
    const Point* const from = path.points.data();
    Point* out = points_.data() + piece.begin;
    if (first < count) {
        out = std::copy(from + first, from + std::min(end, count), out);
    }
    if (end > count) {
        std::copy(from + (std::max(first, count) - count), from + (end - count), out);
    }
    if (piece.end == path.end) {
        points_[path.end] = path.closed ? path[0] : path[count - 1];
        points_[path.end + 1] = path[path.closed ? 1 : 0];
    }
}

std::size_t EdgeRuns::find_turns(const Piece& piece, Vector<std::uint32_t>& turns) const {
    const std::size_t edges = piece.end - piece.begin;
    if (turns.size() < edges) {
        turns.resize(edges);
    }
    return kernels_.find_turns(points_.data() + piece.begin, edges, turns.data());
}

void EdgeRuns::write_runs(const Piece& piece, std::span<const std::uint32_t> turns, EdgeRun* out) const noexcept {
    const Point* const points = points_.data();
    std::size_t begin = piece.begin;
    const auto write = [&](std::size_t end) {
        const Point from = points[begin];
        const Point to = points[end];
        const auto right = static_cast<std::int8_t>(sign_of(std::int64_t{to.x} - from.x));
        const auto up = static_cast<std::int8_t>(sign_of(std::int64_t{to.y} - from.y));
        *out++ = {FlatBox::around(from, to), begin, end, piece.path, right, up};
        begin = end;
    };
    for (const std::uint32_t turn : turns) {
        write(piece.begin + turn);
    }
    write(piece.end);
}

}  // namespace lamella
