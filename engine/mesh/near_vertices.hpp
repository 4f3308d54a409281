// Which of a mesh's vertices lie within a tolerance before a given one, in the order of (x, y, z). They are kept by the
// cells of a grid so coarse that a search seldom has to look into two:
//
//     items    [ cell  | cell        | ... ]     vertices, ascending within a cell, so that a search goes down from the
//                  <- x                          vertex's own place until x is out of reach
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>

#include "base/numbers.hpp"
#include "base/parallel_sort.hpp"
#include "lamella/array.hpp"

namespace lamella {

/// A vertex as the mesh has it.
template <class Real>
struct Place {
    Real at[3];

    friend bool operator==(const Place& a, const Place& b) noexcept {
        return a.at[0] == b.at[0] && a.at[1] == b.at[1] && a.at[2] == b.at[2];
    }
    friend bool operator<(const Place& a, const Place& b) noexcept {
        return std::lexicographical_compare(a.at, a.at + 3, b.at, b.at + 3);
    }
};

template <class Real>
class NearVertices {
public:
    using Vertex = std::uint32_t;
    static constexpr Vertex none = std::numeric_limits<Vertex>::max();

    /// `places` ascend and outlive this. Six calls of run(); O(v log v) for v vertices. Throws std::bad_alloc.
    NearVertices(std::span<const Place<Real>> places, double tolerance, const Parallel& parallel)
        : places_(places),
          tolerance_(tolerance),
          shift_(64 - std::max(1, static_cast<int>(std::bit_width(places.size() / 4)))),
          items_(parallel.memory()),
          firsts_(parallel.memory()),
          kept_until_(parallel.memory()) {
        constexpr std::size_t grain = 8192;
        items_.resize_discarding(places.size());
        kept_until_.resize_discarding(places.size());
        parallel.run_ranges(places.size(), grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t v = begin; v != end; ++v) {
                items_[v] = {hash_of(cell_of(static_cast<Vertex>(v))), static_cast<Vertex>(v)};
                kept_until_[v] = is_kept;
            }
        });
        sort_in_parallel(items_.span(), std::less<>{}, parallel, parallel.memory());
        firsts_.resize_discarding((std::size_t{1} << (64 - shift_)) + 1);
        parallel.run_ranges(places.size() + 1, grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i != end; ++i) {
                const std::size_t from = i == 0 ? 0 : bucket_of(items_[i - 1].hash) + 1;
                const std::size_t to = i == places.size() ? firsts_.size() : bucket_of(items_[i].hash) + 1;
                std::fill(firsts_.begin() + from, firsts_.begin() + to, static_cast<std::uint32_t>(i));
            }
        });
    }

    /// True if a vertex before it lies within the tolerance.
    bool has_earlier(Vertex vertex) const {
        bool found = false;
        for_each_cell_near(vertex, [&](std::uint64_t hash) {
            for (std::size_t p = place_of(hash, vertex); !found && leads_on(p, hash, vertex); --p) {
                found = squared_distance(vertex, items_[p - 1].vertex) <= tolerance_ * tolerance_;
            }
        });
        return found;
    }

    /// The nearest of the vertices before it that are within the tolerance and not dropped, the first of those as near; or
    /// none.
    Vertex nearest_kept(Vertex vertex) {
        Vertex nearest = none;
        double nearest_squared = tolerance_ * tolerance_;
        for_each_cell_near(vertex, [&](std::uint64_t hash) {
            for (std::size_t p = last_kept(place_of(hash, vertex)); leads_on(p, hash, vertex); p = last_kept(p - 1)) {
                const Vertex other = items_[p - 1].vertex;
                const double squared = squared_distance(vertex, other);
                if (squared < nearest_squared || (squared == nearest_squared && other < nearest)) {
                    nearest = other;
                    nearest_squared = squared;
                }
            }
        });
        return nearest;
    }

    /// It is never found again. To be called in ascending order.
    void drop(Vertex vertex) {
        const std::size_t place = place_of(hash_of(cell_of(vertex)), vertex);
        kept_until_[place] = static_cast<std::uint32_t>(place);
    }

    double squared_distance(Vertex a, Vertex b) const noexcept {
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double difference = coordinate(a, axis) - coordinate(b, axis);
            sum += difference * difference;
        }
        return sum;
    }

private:
    using CellNumbers = std::array<std::int64_t, 3>;
    /// A vertex and the hash of its cell. Cells that share a hash are searched together, which does no harm.
    struct Item {
        std::uint64_t hash;
        Vertex vertex;
        friend bool operator<(const Item& a, const Item& b) noexcept {
            return a.hash != b.hash ? a.hash < b.hash : a.vertex < b.vertex;
        }
    };
    static constexpr double cells_per_tolerance = 1.0 / 16;
    static constexpr std::uint32_t is_kept = std::numeric_limits<std::uint32_t>::max();

    double coordinate(Vertex vertex, int axis) const noexcept { return static_cast<double>(places_[vertex].at[axis]); }
    std::int64_t cell_of(double at) const noexcept {
        return static_cast<std::int64_t>(std::floor(at / tolerance_ * cells_per_tolerance));
    }
    CellNumbers cell_of(Vertex vertex) const noexcept {
        return {cell_of(coordinate(vertex, 0)), cell_of(coordinate(vertex, 1)), cell_of(coordinate(vertex, 2))};
    }
    static std::uint64_t hash_of(const CellNumbers& cell) noexcept {
        std::uint64_t hash = 0;
        for (const std::int64_t number : cell) {
            hash = mix64(hash ^ static_cast<std::uint64_t>(number));
        }
        return hash;
    }
    std::size_t bucket_of(std::uint64_t hash) const noexcept { return static_cast<std::size_t>(hash >> shift_); }

    /// Where the vertex stands, or would stand, among the items of a cell.
    std::size_t place_of(std::uint64_t hash, Vertex vertex) const noexcept {
        const std::size_t bucket = bucket_of(hash);
        const Item* const begin = items_.begin() + firsts_[bucket];
        const Item* const end = items_.begin() + firsts_[bucket + 1];
        return static_cast<std::size_t>(std::lower_bound(begin, end, Item{hash, vertex}) - items_.begin());
    }

    /// True if the item before p is of the cell, and not out of reach: then so are all before it.
    bool leads_on(std::size_t p, std::uint64_t hash, Vertex vertex) const noexcept {
        return p > 0 && items_[p - 1].hash == hash &&
               coordinate(vertex, 0) - coordinate(items_[p - 1].vertex, 0) <= tolerance_;
    }

    /// Calls see(hash) for each cell that the tolerance around the vertex reaches.
    template <class See>
    void for_each_cell_near(Vertex vertex, const See& see) const {
        CellNumbers low;
        CellNumbers high;
        for (int axis = 0; axis < 3; ++axis) {
            low[static_cast<std::size_t>(axis)] = cell_of(coordinate(vertex, axis) - tolerance_);
            high[static_cast<std::size_t>(axis)] = cell_of(coordinate(vertex, axis) + tolerance_);
        }
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
            for (std::int64_t y = low[1]; y <= high[1]; ++y) {
                for (std::int64_t z = low[2]; z <= high[2]; ++z) {
                    see(hash_of({x, y, z}));
                }
            }
        }
    }

    /// The end of items up to `end` without the dropped ones at their end. Runs of those are passed at once the next time.
    std::size_t last_kept(std::size_t end) {
        std::size_t p = end;
        while (p > 0 && kept_until_[p - 1] != is_kept) {
            p = kept_until_[p - 1];
        }
        if (p != end) {
            kept_until_[end - 1] = static_cast<std::uint32_t>(p);
        }
        return p;
    }

    std::span<const Place<Real>> places_;
    double tolerance_;
    int shift_;
    Array<Item> items_;                ///< ascending
    Array<std::uint32_t> firsts_;      ///< by the highest bits of a hash: its first item, and the end of the last
    Array<std::uint32_t> kept_until_;  ///< by item: is_kept, or of a dropped one that no item from here on to itself is kept
};

}  // namespace lamella
