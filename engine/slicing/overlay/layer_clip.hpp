// One layer's polylines, cut where they enter and leave a region.
//
//     find_crossings   where the region's edges cross an edge of a polyline, in order along it, by a tree of their runs
//     Sides::pass      there the winding numbers just left and just right of the polyline change
//     turn             where what is filled on its sides begins or ceases to be wanted, a piece begins or ends
//
//           left:   0       1      1   0     What only touches the polyline changes the number on one side. So a boundary
//                       .----------.         along which the polyline runs is told from one that it crosses.
//     ---->-------------+------+---+---
//           right:  0       0  | 1 | 0
//                              '---'
//
// find_start() finds the numbers at a polyline's start, and at a corner on the boundary, in the same tree: of a stretch of a
// contour that lies behind that point as a whole, seen along the edge, the two ends say how often it crosses the line
// behind. All of that is exact. Only the points where pieces are cut are rounded, each once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/overlay.hpp"
#include "slicing/edges/edge_runs.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/overlay/set_reader.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

/// Layer after layer; scratch is kept. One per thread.
class LayerClip {
public:
    explicit LayerClip(Worker& worker) noexcept : worker_(worker) {}

    /// Appends the pieces of the polylines in layer `n` of `lines` to `out`. Returns 1 + the number of the last polyline of
    /// which there are any, or 0. Throws std::bad_alloc.
    std::uint32_t run(const Layers& lines, const LayerSet& by, const ClipOptions& options, double grid_mm, std::uint64_t n,
                      BandOutput& out);

private:
    /// Winding numbers of the region on the two sides of the edge that is followed.
    struct Sides {
        int left = 0;
        int right = 0;

        /// Passes an edge, or several that follow one another, from a point on the side `from` to one on the side `to`: 1
        /// left, -1 right, 0 on the line, which is right of what is just left of it, and left of what is just right.
        void pass(int weight, int from, int to) noexcept {
            left -= weight * ((to > 0) - (from > 0));
            right -= weight * ((to >= 0) - (from >= 0));
        }
    };
    /// Where an edge of the region crosses the edge that is followed, or ends on it: part / whole of the way.
    struct Crossing {
        std::uint64_t part;
        std::uint64_t whole;
        std::size_t edge;
        int weight;
    };
    enum class Place { no_matter, behind, unclear };

    void read_region(const LayerSet& by, double grid_mm, std::uint64_t n);
    bool clip(std::span<const Point> points, bool closed, std::uint32_t number, BandOutput& out);
    void begin_edge(Point a, Point b);
    void follow_edge();
    Place place_of(const FlatBox& box) const noexcept;
    void find_start(std::size_t level, std::size_t block);
    void find_start_along(std::size_t begin, std::size_t end, int weight);
    void find_crossings();
    void compare(std::size_t begin, std::size_t end, int weight);
    void add_crossing(std::size_t edge, int weight);
    bool is_wanted() const noexcept;
    void add_point(Point p);
    void turn(Point at);
    bool append_pieces(std::size_t first, std::uint32_t number, BandOutput& out);

    int weight_of(const EdgeRun& run) const noexcept { return weights_[runs_.path_of(run).contour]; }
    int side_of_line_at(std::size_t point) const noexcept { return side_of(a_, b_, runs_.points()[point]); }

    Worker& worker_;
    SetReader reader_{worker_};
    Nester nester_{worker_};
    EdgeRuns runs_{worker_};                         // of the region
    Vector<std::int8_t> weights_{worker_.memory()};  // of its contours: 1 with the solid on the left, or -1
    Vector<Crossing> crossings_{worker_.memory()};   // of the edge that is followed
    Vector<Point> points_{worker_.memory()};         // of a polyline's pieces
    Vector<std::size_t> ends_{worker_.memory()};     // of each piece that has ended, in points_
    ClipOptions options_;
    Point a_, b_;  // the edge that is followed
    double dx_ = 0;
    double dy_ = 0;
    Sides sides_;  // of where it is followed
    bool sides_are_known_ = false;
    bool in_piece_ = false;
};

}  // namespace lamella
