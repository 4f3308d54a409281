#include "slicing/edges/slab_search.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/sort.hpp"

namespace lamella {

namespace {

constexpr std::size_t few_strips = 12;
constexpr std::size_t strip_work = 8;  ///< as StopPace counts it
constexpr double rounding_room = 1;    ///< far more than doubles lose

/// Between the ends of `a`, which lies within those of `b`: `b` is all below it, or all above.
template <class Piece>
bool is_below(const Piece& b, const Piece& a) noexcept {
    const auto below = [&](int end) { return b.high[0] + a.at[end] * (b.high[1] - b.high[0]) < a.low[end]; };
    return below(0) && below(1);
}
template <class Piece>
bool is_above(const Piece& b, const Piece& a) noexcept {
    const auto above = [&](int end) { return b.low[0] + a.at[end] * (b.low[1] - b.low[0]) > a.high[end]; };
    return above(0) && above(1);
}
template <class Piece>
bool meets(const Piece& b, const Piece& a) noexcept {
    return !is_below(b, a) && !is_above(b, a);
}

}  // namespace

/// Where two edges come within the margin of each other, y of one, which is taken on beyond its end, differs from y of the
/// other by no more than the margin and what one rises along it. Steep ones are a box.
SlabSearch::Strip SlabSearch::strip_of(Point a, Point b, double margin) noexcept {
    if (b.x < a.x) {
        std::swap(a, b);
    }
    const double wide = static_cast<double>(b.x) - a.x;
    const double tall = static_cast<double>(b.y) - a.y;
    const double room = margin + rounding_room;
    const double left = a.x - room;
    const double right = b.x + room;
    if (wide <= 8 * room) {
        return {left, right, std::min(a.y, b.y) - room, std::max(a.y, b.y) + room, 0, 0, 0};
    }
    const double slope = tall / wide;
    const double thick = room + room * std::abs(slope);
    const double y = a.y - room * slope;
    return {left, right, y - thick, y + thick, slope, 0, 0};
}

void SlabSearch::find(const EdgeRuns& runs, Meet meet) {
    runs_ = &runs;
    meet_ = &meet;
    strips_.clear();
    double left = 0;
    double right = 0;
    for (std::uint32_t r = 0; r < runs.runs().size(); ++r) {
        const EdgeRun& run = runs.runs()[r];
        for (std::size_t edge = run.begin; edge < run.end; ++edge) {
            Strip& strip = strips_.emplace_back(strip_of(runs.points()[edge], runs.points()[edge + 1], runs.margin()));
            strip.run = r;
            strip.edge = edge;
            left = std::min(left, strip.left);
            right = std::max(right, strip.right);
        }
        worker_.spend(strip_work * (run.end - run.begin));
    }
    listed_.resize(strips_.size());
    std::iota(listed_.begin(), listed_.end(), 0U);
    search(0, left - 1, right + 1);
}

/// The strips are the last ones listed, from `begin` on; they are removed. As deep as the logarithm of their number.
void SlabSearch::search(std::size_t begin, double left, double right) {
    bool any_ends = true;
    do {
        any_ends = list_pieces(std::span(listed_).subspan(begin), left, right);
        listed_.resize(begin);
        if (pieces_.size() <= few_strips) {
            compare_all(pieces_);
            return;
        }
        const auto ending = std::partition(pieces_.begin(), pieces_.end(), [](const Piece& piece) { return piece.spans(); });
        const std::size_t spanning = static_cast<std::size_t>(ending - pieces_.begin());
        const std::size_t crossing = take_stairs(std::span(pieces_).first(spanning));
        const auto keep = [this](const Piece& piece) {
            meet_stairs(piece);
            listed_.push_back(piece.strip);
        };
        std::for_each(pieces_.begin(), pieces_.begin() + static_cast<std::ptrdiff_t>(crossing), keep);
        std::for_each(ending, pieces_.end(), keep);
    } while (!any_ends);
    const auto middle = ends_.begin() + static_cast<std::ptrdiff_t>(ends_.size() / 2);
    std::nth_element(ends_.begin(), middle, ends_.end());
    const double half = *middle;
    const std::size_t end = listed_.size();
    for (const bool right_half : {false, true}) {
        for (std::size_t i = begin; i < end; ++i) {
            const Strip& strip = strips_[listed_[i]];
            if (right_half ? strip.right > half : strip.left < half) {
                listed_.push_back(listed_[i]);
            }
        }
        search(end, right_half ? half : left, right_half ? right : half);
    }
    listed_.resize(begin);
}

/// And where they end within the slab; true if one does.
bool SlabSearch::list_pieces(std::span<const std::uint32_t> strips, double left, double right) {
    pieces_.clear();
    ends_.clear();
    for (const std::uint32_t s : strips) {
        const Strip& strip = strips_[s];
        const double from = std::max(left, strip.left);
        const double to = std::min(right, strip.right);
        const double rise[] = {(from - strip.left) * strip.slope, (to - strip.left) * strip.slope};
        pieces_.push_back({{(from - left) / (right - left), to < right ? (to - left) / (right - left) : 1},
                           {strip.low + rise[0], strip.low + rise[1]},
                           {strip.high + rise[0], strip.high + rise[1]},
                           s});
        if (strip.left > left) {
            ends_.push_back(strip.left);
        }
        if (strip.right < right) {
            ends_.push_back(strip.right);
        }
    }
    worker_.spend(strip_work * strips.size());
    return !ends_.empty();
}

void SlabSearch::compare_all(std::span<const Piece> pieces) const {
    const auto lies_below = [](const Piece& a, const Piece& b) {
        return std::max(a.high[0], a.high[1]) < std::min(b.low[0], b.low[1]);
    };
    for (std::size_t a = 0; a < pieces.size(); ++a) {
        for (std::size_t b = a + 1; b < pieces.size(); ++b) {
            if (!lies_below(pieces[a], pieces[b]) && !lies_below(pieces[b], pieces[a])) {
                meet(pieces[a], pieces[b]);
            }
        }
    }
}

/// Moves the pieces that are on no stair to the front, and returns how many.
std::size_t SlabSearch::take_stairs(std::span<Piece> spanning) {
    stairs_.clear();
    stair_pieces_.clear();
    sort_briefly(spanning.begin(), spanning.end(), [this](const Piece& a, const Piece& b) {
        worker_.spend(1);
        return a.low[0] + a.high[0] < b.low[0] + b.high[0];
    });
    std::size_t left = 0;
    for (const Piece& piece : spanning) {
        if (stairs_.empty() || is_below(stairs_.back().hull, piece)) {
            stairs_.push_back({piece, stair_pieces_.size(), stair_pieces_.size() + 1});
            stair_pieces_.push_back(piece);
        } else if (joins_last(piece)) {
            Stair& stair = stairs_.back();
            for (const Piece& other : pieces_of(stair)) {
                meet(other, piece);
            }
            for (const int end : {0, 1}) {
                stair.hull.low[end] = std::min(stair.hull.low[end], piece.low[end]);
                stair.hull.high[end] = std::max(stair.hull.high[end], piece.high[end]);
            }
            stair_pieces_.push_back(piece);
            stair.end = stair_pieces_.size();
        } else {
            spanning[left++] = piece;
        }
    }
    return left;
}

/// True if it meets all pieces of the last stair, and the stair before lies below it. So edges along each other, which meet
/// in every slab, are one stair.
bool SlabSearch::joins_last(const Piece& piece) const noexcept {
    const std::span<const Piece> last = pieces_of(stairs_.back());
    return (stairs_.size() == 1 || is_below(stairs_.end()[-2].hull, piece)) &&
           std::all_of(last.rbegin(), last.rend(), [&](const Piece& other) { return meets(other, piece); });
}

void SlabSearch::meet_stairs(const Piece& piece) const {
    auto stair =
        std::partition_point(stairs_.begin(), stairs_.end(), [&](const Stair& each) { return is_below(each.hull, piece); });
    for (; stair != stairs_.end() && !is_above(stair->hull, piece); ++stair) {
        for (const Piece& other : pieces_of(*stair)) {
            if (meets(other, piece)) {
                meet(other, piece);
            }
        }
    }
    worker_.spend(strip_work);
}

void SlabSearch::meet(const Piece& a, const Piece& b) const {
    const Strip& from = strips_[a.strip];
    const Strip& to = strips_[b.strip];
    worker_.spend(1);
    if (from.run != to.run) {
        (*meet_)(runs_->runs()[from.run].path, from.edge, runs_->runs()[to.run].path, to.edge);
    }
}

}  // namespace lamella
