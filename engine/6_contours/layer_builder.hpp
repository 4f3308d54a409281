// Stage 6, from links to contours: the points of a plane in walking order, each contour from its canonical start, oriented
// and nested (stage 7), the layer in canonical order, appended to a band's output.
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "6_contours/link_graph.hpp"
#include "7_nesting/nest.hpp"
#include "base/kernels.hpp"
#include "lamella/array.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// What a band of planes yields, kept by its thread until the bands below have been placed. Indices are relative to the
/// band.
struct BandOutput {
    explicit BandOutput(std::pmr::memory_resource* memory) : points(memory), contours(memory), layer_contours(memory) {}

    Array<Point> points;  ///< capacity ahead of need; `point_count` are filled
    std::size_t point_count = 0;
    std::pmr::vector<Contour> contours;
    std::pmr::vector<std::uint32_t> layer_contours;  ///< contours of each plane

    void clear() noexcept {
        point_count = 0;
        contours.clear();
        layer_contours.clear();
    }
    /// Makes room for `count` more points. Throws std::bad_alloc.
    Point* reserve_points(std::size_t count);
};

class LayerBuilder {
public:
    explicit LayerBuilder(std::pmr::memory_resource* memory);

    /// Appends the layer that `graph` holds to `out`; points[slot] is where the slot's edge pierces the plane.
    /// O(q log q) for q points. Throws std::bad_alloc.
    void build(const LinkGraph& graph, const Point* points, BandOutput& out);

    /// Appends a layer without contours.
    static void skip(BandOutput& out) { out.layer_contours.push_back(0); }

    /// Time spent in nesting since construction, for layers built with `timed`; see StageTimes.
    std::uint64_t nesting_ticks = 0;
    bool timed = false;

private:
    void gather(const LinkGraph& graph, const Point* points);
    void examine_closed(const LinkGraph& graph, const WalkedContour& walked, Point* ring);
    void examine_open(const LinkGraph& graph, const WalkedContour& walked, Point* ring);
    std::uint32_t pick_start(const LinkGraph& graph, const WalkedContour& walked, const Point* ring,
                             const RingFacts& facts) const;
    void sort_canonically();
    bool starts_before(std::uint32_t a, std::uint32_t b) const;
    void append(BandOutput& out);
    static void append_points(const NestItem& item, Point* to);

    const Kernels& kernels_;
    Nester nester_;
    std::pmr::vector<Point> rings_;  // the plane's points in walking order, each contour with room to close it
    std::pmr::vector<NestItem> items_;
    std::pmr::vector<EndKey> start_keys_;
    std::pmr::vector<std::uint32_t> segments_;
    std::pmr::vector<std::uint32_t> by_start_;
    std::pmr::vector<std::uint64_t> placed_;  // leader's rank << 32 | own rank
    std::pmr::vector<std::uint32_t> rank_;
};

}  // namespace lamella
