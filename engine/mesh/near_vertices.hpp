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
#include <limits>
#include <span>
#include <vector>

#include "base/distribute.hpp"
#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"

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

    /// `places` ascend and outlive this. Three calls of run(); O(v) expected for v vertices. Throws std::bad_alloc.
    NearVertices(std::span<const Place<Real>> places, double tolerance, const Parallel& parallel)
        : places_(places),
          tolerance_(tolerance),
          cells_(parts_for(places.size(), std::size_t{1} << 15), Vector<Cell>(parallel.memory())),
          items_(distribute<Vertex>(
              places.size(), cells_.size(), parallel,
              [this](std::size_t begin, std::size_t end, const auto& emit) {
                  for (std::size_t v = begin; v != end; ++v) {
                      emit(part_of(hash_of(cell_of(static_cast<Vertex>(v)))), static_cast<Vertex>(v));
                  }
              },
              parallel.memory())),
          kept_until_(parallel.memory()) {
        std::vector<std::vector<std::uint32_t>> scratch(static_cast<std::size_t>(parallel.threads()));
        kept_until_.resize_discarding(places.size());
        parallel.run(cells_.size(),
                     [&](std::size_t part, int worker) { sort_part(part, scratch[static_cast<std::size_t>(worker)]); });
    }

    /// True if a vertex before it lies within the tolerance.
    bool has_earlier(Vertex vertex) const {
        bool found = false;
        for_each_cell_near(vertex, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t p = end; !found && p > begin && in_reach(vertex, items_.items[p - 1]); --p) {
                found = squared_distance(vertex, items_.items[p - 1]) <= tolerance_ * tolerance_;
            }
        });
        return found;
    }

    /// The nearest of the vertices before it that are within the tolerance and not dropped, the first of those as near; or
    /// none.
    Vertex nearest_kept(Vertex vertex) {
        Vertex nearest = none;
        double nearest_squared = tolerance_ * tolerance_;
        for_each_cell_near(vertex, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t p = last_kept(begin, end); p > begin && in_reach(vertex, items_.items[p - 1]);
                 p = last_kept(begin, p - 1)) {
                const Vertex other = items_.items[p - 1];
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
        const CellNumbers cell = cell_of(vertex);
        for_each_before(cell, vertex, [&](std::uint32_t, std::uint32_t end) { kept_until_[end] = end; });
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
    /// A cell's vertices: items [begin, end). Empty: no cell.
    struct Cell {
        std::uint32_t begin = 0;
        std::uint32_t end = 0;
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
    std::size_t part_of(std::uint64_t hash) const noexcept {
        return part_of_number(hash >> 32, std::uint64_t{1} << 32, cells_.size());
    }
    bool in_reach(Vertex vertex, Vertex other) const noexcept {
        return coordinate(vertex, 0) - coordinate(other, 0) <= tolerance_;
    }

    /// The items of a part by cell: counted, then scattered by way of `scratch`.
    void sort_part(std::size_t part, std::vector<std::uint32_t>& scratch) {
        const std::span<Vertex> own = items_.of(part);
        Vector<Cell>& cells = cells_[part];
        cells.assign(std::bit_ceil(own.size() + own.size() / 2 + 1), Cell{});
        scratch.resize(2 * own.size());
        std::uint32_t* const cell_at = scratch.data();
        for (std::size_t i = 0; i < own.size(); ++i) {  // for now `begin` is a cell's first vertex, and `end` their number
            const CellNumbers cell = cell_of(own[i]);
            std::size_t at = hash_of(cell) & (cells.size() - 1);
            while (cells[at].end != 0 && cell_of(static_cast<Vertex>(cells[at].begin)) != cell) {
                at = (at + 1) & (cells.size() - 1);
            }
            cells[at].begin = cells[at].end == 0 ? own[i] : cells[at].begin;
            ++cells[at].end;
            cell_at[i] = static_cast<std::uint32_t>(at);
        }
        const auto first = static_cast<std::uint32_t>(items_.firsts[part]);
        std::uint32_t sum = first;
        for (Cell& cell : cells) {
            const std::uint32_t count = cell.end;
            cell = {sum, sum};
            sum += count;
        }
        Vertex* const sorted = scratch.data() + own.size();
        for (std::size_t i = 0; i < own.size(); ++i) {
            sorted[cells[cell_at[i]].end++ - first] = own[i];
        }
        std::copy(sorted, sorted + own.size(), own.begin());
        std::fill_n(kept_until_.begin() + first, own.size(), is_kept);
    }

    /// Calls see(begin, end) for the items of the cell before `vertex`, if there is the cell.
    template <class See>
    void for_each_before(const CellNumbers& cell, Vertex vertex, const See& see) const {
        const std::uint64_t hash = hash_of(cell);
        const Vector<Cell>& cells = cells_[part_of(hash)];
        for (std::size_t at = hash & (cells.size() - 1); cells[at].begin != cells[at].end;
             at = (at + 1) & (cells.size() - 1)) {
            const Vertex* const begin = items_.items.data() + cells[at].begin;
            if (cell_of(*begin) == cell) {
                const Vertex* const end = items_.items.data() + cells[at].end;
                see(cells[at].begin,
                    cells[at].begin + static_cast<std::uint32_t>(std::lower_bound(begin, end, vertex) - begin));
                return;
            }
        }
    }

    /// The same for each cell that the tolerance around the vertex reaches.
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
                    for_each_before({x, y, z}, vertex, see);
                }
            }
        }
    }

    /// The end of items [begin, end) without the dropped ones at their end. Runs of those are passed at once the next time.
    std::uint32_t last_kept(std::uint32_t begin, std::uint32_t end) {
        std::uint32_t p = end;
        while (p > begin && kept_until_[p - 1] != is_kept) {
            p = kept_until_[p - 1];
        }
        p = std::max(p, begin);
        if (end > begin && kept_until_[end - 1] != is_kept) {
            kept_until_[end - 1] = p;
        }
        return p;
    }

    std::span<const Place<Real>> places_;
    double tolerance_;
    std::vector<Vector<Cell>> cells_;  ///< by part, then by the cells' hashes: open addressing
    Distributed<Vertex> items_;
    /// By item: is_kept, or of a dropped one that no item from here on to itself is kept.
    Array<std::uint32_t> kept_until_;
};

}  // namespace lamella
