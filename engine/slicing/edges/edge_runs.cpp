#include "slicing/edges/edge_runs.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <new>

#include "base/numbers.hpp"

namespace lamella {

namespace {

/// The directions in which a path has gone since it last turned, 0 if neither way.
class Heading {
public:
    bool turns_at(Point from, Point to) noexcept {
        const int right = sign_of(std::int64_t{to.x} - from.x);
        const int up = sign_of(std::int64_t{to.y} - from.y);
        const bool turns = right * right_ < 0 || up * up_ < 0;
        right_ = right != 0 || turns ? right : right_;
        up_ = up != 0 || turns ? up : up_;
        return turns;
    }
    bool is_slanting() const noexcept { return right_ != 0 && up_ != 0; }
    /// Bit 0: right, bit 1: up. Precondition: slanting.
    unsigned bits() const noexcept { return (right_ > 0 ? 1U : 0U) | (up_ > 0 ? 2U : 0U); }
    void set(unsigned bits) noexcept {
        right_ = (bits & 1U) != 0 ? 1 : -1;
        up_ = (bits & 2U) != 0 ? 1 : -1;
    }

private:
    int right_ = 0;
    int up_ = 0;
};

std::size_t find_turns_portable(const Point* points, std::size_t edges, std::uint32_t* out) {
    std::size_t found = 0;
    Heading heading;
    for (std::size_t e = 0; e < edges; ++e) {
        out[found] = static_cast<std::uint32_t>(e);
        found += heading.turns_at(points[e], points[e + 1]) ? 1 : 0;
    }
    return found;
}

#ifdef LAMELLA_X86_FORMS

LAMELLA_AVX2_INLINE __m256i lanes_at(const void* at) {
    return _mm256_loadu_si256(static_cast<const __m256i*>(at));
}
LAMELLA_AVX2_INLINE unsigned greater(__m256i a, __m256i b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(a, b))));
}

/// Two bits an edge, of turn_lanes edges: whether x ascends, and y; whether it descends.
struct Directions {
    std::uint64_t ascends = 0;
    std::uint64_t descends = 0;
};

LAMELLA_AVX2_INLINE Directions directions_of(const Point* points) {
    constexpr std::size_t step = 4;
    Directions all;
    for (std::size_t e = 0; e < turn_lanes; e += step) {
        const __m256i here = lanes_at(points + e);
        const __m256i next = lanes_at(points + e + 1);
        all.ascends |= std::uint64_t{greater(next, here)} << (2 * e);
        all.descends |= std::uint64_t{greater(here, next)} << (2 * e);
    }
    return all;
}

/// The edges [0, edges) that follow one another in both directions: writes `first` + edge for those before which the path
/// turns. Precondition: `heading` is slanting, as are all these edges.
LAMELLA_AVX2_INLINE std::size_t write_turns(std::uint64_t ascends, std::size_t edges, Heading& heading, std::size_t first,
                                            std::uint32_t* out) {
    constexpr std::uint64_t bits_of_x = 0x5555'5555'5555'5555;
    const std::uint64_t used = ~std::uint64_t{0} >> (64 - 2 * edges);
    const std::uint64_t changes = (ascends ^ (ascends << 2 | heading.bits())) & used;
    std::size_t found = 0;
    for (std::uint64_t turns = (changes | changes >> 1) & bits_of_x; turns != 0; turns &= turns - 1) {
        out[found++] = static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(std::countr_zero(turns)) / 2;
    }
    heading.set(static_cast<unsigned>(ascends >> (2 * edges - 2)) & 3U);
    return found;
}

/// Edges along an axis are taken one by one, with the seven beside them.
LAMELLA_AVX2 std::size_t find_turns_avx2(const Point* points, std::size_t edges, std::uint32_t* out) {
    constexpr std::size_t step = 8;
    std::size_t found = 0;
    Heading heading;
    if (edges > 0) {
        heading.turns_at(points[0], points[1]);
    }
    for (std::size_t e = 0; e < edges; e += turn_lanes) {
        const Directions directions = directions_of(points + e);
        const std::size_t count = std::min(edges - e, turn_lanes);
        const std::uint64_t upright = ~(directions.ascends | directions.descends) & ~std::uint64_t{0} >> (64 - 2 * count);
        if (upright == 0 && heading.is_slanting()) {
            found += write_turns(directions.ascends, count, heading, e, out + found);
            continue;
        }
        for (std::size_t i = 0; i < count; i += step) {
            const std::size_t few = std::min(count - i, step);
            if ((upright >> (2 * i) & 0xFFFF) == 0 && heading.is_slanting()) {
                found += write_turns(directions.ascends >> (2 * i), few, heading, e + i, out + found);
                continue;
            }
            for (std::size_t k = e + i; k < e + i + few; ++k) {
                out[found] = static_cast<std::uint32_t>(k);
                found += heading.turns_at(points[k], points[k + 1]) ? 1 : 0;
            }
        }
    }
    return found;
}

#endif

}  // namespace

std::span<const Form<FindTurns>> find_turns_forms() noexcept {
    static constexpr Form<FindTurns> forms[] = {
#ifdef LAMELLA_X86_FORMS
        {InstructionSet::avx2, find_turns_avx2},
#endif
        {InstructionSet::portable, find_turns_portable}};
    return forms;
}

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
    order_by_place(
        std::span(paths_), [](const EdgePath& path) { return path.place; }, worker_);
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
        *out++ = {FlatBox::around(points[begin], points[end]), begin, end, piece.path};
        begin = end;
    };
    for (std::size_t turn = 0; turn < piece.turns; ++turn) {
        write(piece.begin + turns_[piece.begin + turn]);
    }
    write(piece.end);
}

}  // namespace lamella
