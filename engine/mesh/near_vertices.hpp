// The vertices that a weld keeps, found again by where they lie: in chains, one for each cell of a grid so coarse that a
// search seldom has to look into two.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "base/numbers.hpp"
#include "base/parallel.hpp"
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

    /// No vertex is kept yet. `places` ascend and outlive this. Throws std::bad_alloc.
    NearVertices(std::span<const Place<Real>> places, double tolerance, const Parallel& parallel)
        : places_(places), tolerance_(tolerance), newest_(parallel.memory()), before_(parallel.memory()) {
        newest_.resize_discarding(std::bit_ceil(places.size() / 2 + 1));
        std::fill(newest_.begin(), newest_.end(), none);
        before_.resize_discarding(places.size());
    }

    /// To be called in ascending order.
    void keep(Vertex vertex) { before_[vertex] = std::exchange(newest_[chain_of(cell_of(vertex))], vertex); }

    /// The nearest of the vertices that are kept and within the tolerance, the first of those as near; or none. Of a chain,
    /// which descends, all lie beyond reach from the first on that does in x.
    Vertex nearest(Vertex vertex) const {
        Vertex nearest = none;
        double nearest_squared = tolerance_ * tolerance_;
        for_each_chain_near(vertex, [&](Vertex other) {
            for (; other != none && coordinate(vertex, 0) - coordinate(other, 0) <= tolerance_; other = before_[other]) {
                const double squared = squared_distance(vertex, other);
                if (squared < nearest_squared || (squared == nearest_squared && other < nearest)) {
                    nearest = other;
                    nearest_squared = squared;
                }
            }
        });
        return nearest;
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
    static constexpr double cells_per_tolerance = 1.0 / 16;

    double coordinate(Vertex vertex, int axis) const noexcept { return static_cast<double>(places_[vertex].at[axis]); }

    /// Of the place that lies `beside` the vertex on all axes.
    CellNumbers cell_of(Vertex vertex, double beside = 0) const noexcept {
        const auto number = [&](int axis) {
            return static_cast<std::int64_t>(
                std::floor((coordinate(vertex, axis) + beside) / tolerance_ * cells_per_tolerance));
        };
        return {number(0), number(1), number(2)};
    }

    /// Cells that share a chain are searched together, which does no harm.
    std::size_t chain_of(const CellNumbers& cell) const noexcept {
        std::uint64_t hash = 0;
        for (const std::int64_t number : cell) {
            hash = mix64(hash ^ static_cast<std::uint64_t>(number));
        }
        return static_cast<std::size_t>(hash) & (newest_.size() - 1);
    }

    /// Calls see(newest vertex of the chain) for each cell that the tolerance around the vertex reaches.
    template <class See>
    void for_each_chain_near(Vertex vertex, const See& see) const {
        const CellNumbers low = cell_of(vertex, -tolerance_);
        const CellNumbers high = cell_of(vertex, tolerance_);
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
            for (std::int64_t y = low[1]; y <= high[1]; ++y) {
                for (std::int64_t z = low[2]; z <= high[2]; ++z) {
                    see(newest_[chain_of({x, y, z})]);
                }
            }
        }
    }

    std::span<const Place<Real>> places_;
    double tolerance_;
    Array<Vertex> newest_;  ///< by chain; none where it is empty
    Array<Vertex> before_;  ///< by kept vertex: the one before it in its chain
};

}  // namespace lamella
