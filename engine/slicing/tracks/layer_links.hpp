// Which islands of a layer share area with which of the next one, and which voids.
//
//     look_up     what the start of each contour lies in, in the other layer: most islands that overlap are found so
//     mark        where others may meet an island of which that is not known; the same of its other extreme points
//     meet        edges there: a proper crossing, or sectors that overlap where a contour passes a point of another
//
// That is all: let two islands overlap, each connected, with none of these. No point of either's outer lies within the
// other, for at a contact the sectors would show it, and without one the start would. So each lies within the other's outer,
// and the outers are equal: then they have edges in the same direction. Voids touch in points as one, and so all their
// contours are looked up; at a point they overlap where all sectors there leave something open.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "lamella/tracks.hpp"
#include "slicing/edges/edge_runs.hpp"
#include "slicing/edges/pair_search.hpp"
#include "slicing/nesting/inside.hpp"
#include "slicing/tracks/sectors.hpp"

namespace lamella {

inline constexpr std::uint32_t no_track = std::numeric_limits<std::uint32_t>::max();

/// A closed contour, with what lies on its two sides.
struct TrackRing {
    FlatBox box;
    std::span<const Point> points;  ///< from its smallest
    std::uint32_t island = no_track;
    std::uint32_t empty = 0;  ///< the void
    bool is_outer = true;
};

/// A layer as LayerLinks reads it.
struct TrackLayer {
    std::span<const TrackRing> rings;        ///< in the order of contours
    std::span<const std::uint32_t> by_size;  ///< rings, the smallest first; of equal ones outers first
    std::uint32_t first_island = 0;          ///< islands and voids of a layer follow one another
    std::uint32_t islands = 0;
    std::uint32_t outside = 0;  ///< the first of the voids
};

/// One pair of layers after another; its memory is kept. One per thread.
class LayerLinks {
public:
    explicit LayerLinks(Worker& worker) noexcept : worker_(worker) {}

    /// Fills `islands` with the links of islands by lower, then upper, and `voids`, unless null, with those of voids.
    /// Throws std::bad_alloc.
    void run(const TrackLayer& lower, const TrackLayer& upper, Vector<TrackLink>& islands, Vector<TrackLink>* voids);

private:
    static constexpr std::size_t extremes = 4;  ///< the start, and the rightmost, the lowest and the highest point

    /// A point of a contour, and what it lies in, in the other layer: neither island nor void if on a contour.
    struct Asked {
        std::uint32_t ring;
        Point point;
        std::uint32_t island = no_track;
        std::uint32_t empty = no_track;
    };
    /// One of two layers.
    struct Side {
        TrackLayer layer;
        Vector<std::array<std::uint32_t, extremes>> around;  // of each island: the other's islands its points lie in
        Vector<FlatBox> near;                                // of each island: a box around where others may meet it
        Vector<std::uint32_t> outers;                        // rings
        BoxTree<Point> boxes;                                // of outers
        explicit Side(const Memory* memory) : around(memory), near(memory), outers(memory), boxes(memory) {}
        const std::array<std::uint32_t, extremes>& around_island(std::uint32_t island) const {
            return around[island - layer.first_island];
        }
        const FlatBox& near_island(std::uint32_t island) const { return near[island - layer.first_island]; }
    };
    /// Edges of a ring from one of its points on.
    struct Stretch {
        std::uint32_t ring;
        std::uint32_t first;
        bool is_upper;
    };
    /// A point where contours of both layers meet, and the voids there.
    struct Touch {
        Point at;
        TrackLink voids;
    };

    void begin(Side& side, const TrackLayer& layer);
    void ask_starts(const Side& side, const Side& other);
    void ask_extremes(const Side& side, const Side& other);
    void look_up(const Side& in);
    void place(const TrackRing& ring);
    void link_asked(std::size_t side);
    void mark(Side& of, const Side& others);
    void list_wanted();
    bool is_wanted(const FlatBox& box) const;
    void list_stretches(std::size_t side, std::uint32_t ring);
    void list_stretch(std::size_t side, std::uint32_t ring, std::size_t first, std::span<const Point> points);
    void search();
    void meet(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j);
    void cross_voids(const Point* lower, const Point* upper, TrackLink voids);
    void touch(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j);
    void pass(const TrackRing& lower, const Passage& of_lower, const TrackRing& upper, const Passage& of_upper);
    void link_open_points();
    void list_passages(Point at, std::size_t begin, std::size_t end, const EdgePath& path);
    bool lies_within(Point at, std::size_t edge) const noexcept;
    Passage passage_at(const EdgePath& path, std::size_t edge) const noexcept;
    const Stretch& stretch_of(const EdgePath& path) const noexcept { return stretches_[path.contour]; }
    const TrackRing& ring_of(const Stretch& stretch) const noexcept {
        return sides_[stretch.is_upper ? 1 : 0].layer.rings[stretch.ring];
    }
    bool is_linked(std::uint32_t lower, std::uint32_t upper) const {
        return is_known(sides_[0], lower, sides_[1], upper) || last_[lower - sides_[0].layer.first_island] == upper;
    }
    static bool is_known(const Side& a, std::uint32_t of_a, const Side& b, std::uint32_t of_b) {
        const auto has = [](const auto& around, std::uint32_t other) {
            return std::find(around.begin(), around.end(), other) != around.end();
        };
        return has(a.around_island(of_a), of_b) || has(b.around_island(of_b), of_a);
    }
    void link_islands(std::uint32_t lower, std::uint32_t upper) {
        if (!is_linked(lower, upper)) {
            islands_->push_back({lower, upper});
            last_[lower - sides_[0].layer.first_island] = upper;
        }
    }
    void link_voids(std::uint32_t lower, std::uint32_t upper) {
        if (last_voids_.lower != lower || last_voids_.upper != upper) {
            last_voids_ = {lower, upper};
            voids_->push_back(last_voids_);
        }
    }

    Worker& worker_;
    nesting::AddEdges add_edges_ = best_of(nesting::add_edges_forms(), worker_.instructions());
    std::array<Side, 2> sides_{Side(worker_.memory()), Side(worker_.memory())};
    Vector<TrackLink>* islands_ = nullptr;
    Vector<TrackLink>* voids_ = nullptr;
    Vector<std::uint32_t> last_{worker_.memory()};  // of each lower island: the last upper one linked
    TrackLink last_voids_;
    Vector<Asked> asked_{worker_.memory()};
    PointTree points_{worker_};                      // of asked_ that are not placed
    Vector<std::uint32_t> found_{worker_.memory()};  // of asked_
    Vector<std::uint32_t> inside_{worker_.memory()};
    Vector<std::uint32_t> touching_{worker_.memory()};
    nesting::ManyInside many_inside_{worker_};
    Vector<FlatBox> wanted_{worker_.memory()};
    BoxTree<Point> wanted_boxes_{worker_.memory()};
    Vector<Stretch> stretches_{worker_.memory()};
    Vector<std::array<Point, 2>> closing_edges_{worker_.memory()};  // of each ring
    EdgeRuns runs_{worker_};
    PairSearch pairs_{worker_};
    Vector<Touch> touches_{worker_.memory()};
    Vector<Passage> passages_{worker_.memory()};  // through one point
};

}  // namespace lamella
