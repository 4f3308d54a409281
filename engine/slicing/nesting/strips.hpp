// The boxes that a vertical sweep line meets on its way from left to right, found by their y.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lamella/grid.hpp"

namespace lamella {

/// An axis-parallel rectangle with its boundary.
struct FlatBox {
    Point low;
    Point high;

    static FlatBox around(Point a, Point b) noexcept {
        return {{std::min(a.x, b.x), std::min(a.y, b.y)}, {std::max(a.x, b.x), std::max(a.y, b.y)}};
    }
    bool meets(const FlatBox& other) const noexcept {
        return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y && other.low.y <= high.y;
    }
    FlatBox grown(std::int32_t by) const noexcept { return {{low.x - by, low.y - by}, {high.x + by, high.y + by}}; }
    std::int64_t height() const noexcept { return std::int64_t{high.y} - low.y; }
};

/// Horizontal strips about twice as high as the boxes are on average, each with a list of the boxes that reach into it.
class Strips {
public:
    /// Empty, for `count` boxes within `all` whose heights sum to `heights`. Throws std::bad_alloc.
    void begin(const FlatBox& all, std::size_t count, std::int64_t heights) {
        const auto boxes = static_cast<std::int64_t>(count);
        low_ = all.low.y;
        shift_ = 0;
        entries_.clear();
        while (((all.height() >> shift_) > boxes || (std::int64_t{1} << shift_) * boxes < 2 * heights) && shift_ < 32) {
            ++shift_;
        }
        heads_.assign(static_cast<std::size_t>(all.height() >> shift_) + 1, none);
    }

    /// Calls meet(item) once for each item whose box meets `box`, and removes those that end left of it. Returns how many it
    /// visited. Precondition: boxes come in ascending order of low.x.
    template <class Meet>
    std::uint64_t visit(const FlatBox& box, Meet meet) {
        std::uint64_t seen = 0;
        for (std::size_t s = strip(box.low.y); s <= strip(box.high.y); ++s) {
            for (std::uint32_t* link = &heads_[s]; *link != none; ++seen) {
                Entry& entry = entries_[*link];
                if (entry.right_end < box.low.x) {
                    *link = entry.next;
                    continue;
                }
                // Two boxes that share several strips meet in the lowest of them.
                if (entry.low_y <= box.high.y && box.low.y <= entry.high_y && strip(std::max(entry.low_y, box.low.y)) == s) {
                    meet(entry.item);
                }
                link = &entry.next;
            }
        }
        return seen;
    }

    /// Throws std::bad_alloc.
    void add(const FlatBox& box, std::uint32_t item) {
        for (std::size_t s = strip(box.low.y); s <= strip(box.high.y); ++s) {
            entries_.push_back({box.high.x, box.low.y, box.high.y, item, heads_[s]});
            heads_[s] = static_cast<std::uint32_t>(entries_.size() - 1);
        }
    }

private:
    static constexpr std::uint32_t none = 0xffffffff;

    struct Entry {
        std::int32_t right_end;
        std::int32_t low_y;
        std::int32_t high_y;
        std::uint32_t item;
        std::uint32_t next;
    };

    std::size_t strip(std::int32_t y) const noexcept { return static_cast<std::size_t>((std::int64_t{y} - low_) >> shift_); }

    std::int64_t low_ = 0;
    int shift_ = 0;
    std::vector<std::uint32_t> heads_;
    std::vector<Entry> entries_;
};

}  // namespace lamella
