// How far the contours of one layer lie from those of another.
#pragma once

#include <span>

#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/result.hpp"
#include "slicing/grid/box_tree.hpp"

namespace lamella {

/// From everywhere on some edges to the nearest of others; grid units.
struct Distances {
    double sum = 0;     ///< integral over the length, by Simpson's rule along each edge
    double length = 0;  ///< of the edges
    double most = 0;
};

/// The edges of a layer's closed contours, to be asked for the nearest.
class NearestEdges {
public:
    explicit NearestEdges(Worker& worker) : worker_(worker), edges_(worker.memory()), boxes_(worker.memory()) {}

    void assign(const LayerView& layer);
    bool empty() const noexcept { return edges_.empty(); }

    /// Precondition: neither is empty.
    Distances distances_to(const NearestEdges& others) const;

private:
    struct Place {
        double x = 0;
        double y = 0;
    };
    struct Edge {
        Point from;
        Point to;
    };
    struct Nearest {
        std::size_t edge = 0;
        double squared = 0;
    };
    /// A stretch of an edge, and what lies nearest to its ends.
    struct Stretch {
        Place from;
        Place to;
        Nearest from_nearest;
        Nearest to_nearest;
    };

    double squared_distance(const Place& place, std::size_t edge) const noexcept;
    /// `hint`: an edge that may be near.
    Nearest nearest(const Place& place, std::size_t hint) const;
    void find_most(const Stretch& whole, Vector<Stretch>& left, double& most) const;

    Worker& worker_;
    Vector<Edge> edges_;  ///< along contours, so that neighbours lie close
    BoxTree<Point> boxes_;
};

}  // namespace lamella
