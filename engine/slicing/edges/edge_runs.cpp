#include "slicing/edges/edge_runs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "base/numbers.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_edges_of_piece = std::size_t{1} << 13;
constexpr std::size_t pieces_of_task = 8;
constexpr std::size_t piece_work = 16;  ///< as StopPace counts it: pieces have few edges or many

/// Leaves the contents unspecified; memory grows by half, so that layers of many sizes take it only a few times.
template <class T>
void make_room(Array<T>& array, std::size_t count) {
    if (count > array.capacity()) {
        array.resize_discarding(count + count / 2);
    }
    array.set_size(count);
}

}  // namespace

void EdgeRuns::clear() noexcept {
    paths_.clear();
    edges_ = 0;
    point_count_ = 0;
}

void EdgeRuns::add(const EdgePath& path) {
    if (path.edges() == 0) {
        return;
    }
    if (paths_.size() == std::numeric_limits<std::uint32_t>::max()) {
        throw std::bad_alloc();
    }
    EdgePath& listed = paths_.emplace_back(path);
    const Point from = path[0];
    const Point half = path[path.edges() / 2];
    listed.place = {from.x / 2 + half.x / 2, from.y / 2 + half.y / 2};
    edges_ += path.edges();
    point_count_ += path.edges() + 2;
}

void EdgeRuns::cut(std::int32_t margin, const Parallel* parallel) {
    margin_ = margin;
    order_paths();
    list_pieces();
    make_room(points_, point_count_ + turn_lanes);
    make_room(turns_, point_count_);
    const auto each_piece = [&](const auto& work) {
        const auto work_on = [&](std::size_t begin, std::size_t end) {
            std::for_each(pieces_.data() + begin, pieces_.data() + end, work);
        };
        if (parallel == nullptr) {
            worker_.in_stretches(0, pieces_.size(), piece_work, work_on);
        } else {
            parallel->run_ranges(pieces_.size(), pieces_of_task,
                                 [&](std::size_t begin, std::size_t end, int) { work_on(begin, end); });
        }
    };
    each_piece([this](const Piece& piece) { copy_points(piece); });
    each_piece([this](Piece& piece) { find_turns(piece); });
    number_runs();
    each_piece([this](const Piece& piece) { write_runs(piece); });
    const auto box_at = [this](std::size_t run) {
        const FlatBox& box = runs_[run].box;
        return FlatBox{box.low, {box.high.x + margin_, box.high.y + margin_}};
    };
    if (parallel == nullptr) {
        boxes_.assign(runs_.size(), box_at, worker_);
    } else {
        boxes_.assign(runs_.size(), box_at, *parallel);
    }
}

/// A layer's contours come by their starts, of which neighbours may lie far apart along y.
void EdgeRuns::order_paths() {
    double widths = 0;
    double heights = 0;
    for (const EdgePath& path : paths_) {
        const Point half = path[path.edges() / 2];
        widths += std::abs(static_cast<double>(half.x) - path[0].x);
        heights += std::abs(static_cast<double>(half.y) - path[0].y);
    }
    order_by_place(
        std::span(paths_), [](const EdgePath& path) { return path.place; }, worker_, widths / heights);
    std::size_t points = 0;
    for (EdgePath& path : paths_) {
        path.begin = points;
        path.end = points + path.edges();
        points += path.edges() + 2;
    }
}

void EdgeRuns::list_pieces() {
    pieces_.clear();
    for (std::uint32_t path = 0; path < paths_.size(); ++path) {
        for (std::size_t begin = paths_[path].begin; begin < paths_[path].end; begin += most_edges_of_piece) {
            pieces_.push_back({path, begin, std::min(paths_[path].end, begin + most_edges_of_piece), 0, 0});
        }
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

void EdgeRuns::find_turns(Piece& piece) noexcept {
    piece.turns = find_turns_(points_.data() + piece.begin, piece.end - piece.begin, turns_.data() + piece.begin);
}

void EdgeRuns::number_runs() {
    std::size_t count = 0;
    for (Piece& piece : pieces_) {
        piece.first_run = count;
        count += piece.turns + 1;
    }
    if (count >= std::numeric_limits<std::uint32_t>::max()) {
        throw std::bad_alloc();
    }
    make_room(runs_, count);
}

void EdgeRuns::write_runs(const Piece& piece) noexcept {
    const Point* const points = points_.data();
    EdgeRun* out = runs_.data() + piece.first_run;
    std::size_t begin = piece.begin;
    const auto write = [&](std::size_t end) {
        const Point from = points[begin];
        const Point to = points[end];
        const auto right = static_cast<std::int8_t>(sign_of(std::int64_t{to.x} - from.x));
        const auto up = static_cast<std::int8_t>(sign_of(std::int64_t{to.y} - from.y));
        *out++ = {FlatBox::around(from, to), begin, end, piece.path, right, up};
        begin = end;
    };
    for (std::size_t turn = 0; turn < piece.turns; ++turn) {
        write(piece.begin + turns_[piece.begin + turn]);
    }
    write(piece.end);
}

}  // namespace lamella
