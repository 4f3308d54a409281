// find_tracks(), as the list of its stages:
//
//     number       islands and voids of all layers
//     measure      boxes, order by size, areas and centroids: each layer by one thread
//     link         LayerLinks: each pair of layers by one thread
//     write        links in order, and bodies
//     Pockets      from the lowest layer up

#include "lamella/tracks.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/sort.hpp"
#include "base/vector.hpp"
#include "slicing/measures/moments.hpp"
#include "slicing/slicer.hpp"
#include "slicing/tracks/layer_links.hpp"
#include "slicing/tracks/pockets.hpp"

namespace lamella {

namespace {

Int128 magnitude_of(const Contour& contour) noexcept {
    const Int128 area = to_int128(contour.twice_area);
    return area < 0 ? -area : area;
}

/// One call.
class TrackFinding {
public:
    TrackFinding(const SliceResult& stack, const TrackOptions& options, const Context& context)
        : stack_(stack), pockets_(options.pockets), context_(context), parallel_(context), memory_(context.memory) {}

    Tracks find() {
        Tracks tracks(memory_);
        number(tracks);
        parallel_.begin_stage(0.2);
        parallel_.run_ranges(layers_.size(), layers_a_task(), [&](std::size_t first, std::size_t last, int) {
            for (std::size_t n = first; n < last; ++n) {
                measure(n, tracks);
            }
        });
        parallel_.begin_stage(0.9);
        link();
        write(tracks);
        if (pockets_) {
            find_pockets(tracks);
        }
        parallel_.finish();
        return tracks;
    }

private:
    struct PairLinks {
        explicit PairLinks(const Memory* memory) : islands(memory), voids(memory) {}
        Vector<TrackLink> islands, voids;
    };
    struct Linker {
        explicit Linker(const Parallel& parallel) : worker(parallel.memory(), parallel.stop()) {}
        Worker worker;
        LayerLinks links{worker};
    };

    /// Enough points for a thread to be woken for.
    std::size_t layers_a_task() const noexcept {
        constexpr std::size_t enough_points = 1 << 14;
        return 1 + layers_.size() * enough_points / (stack_.points.size() + 1);
    }
    void number(Tracks& tracks);
    void number(std::size_t n, Tracks& tracks);
    void measure(std::size_t n, Tracks& tracks);
    void link();
    void write(Tracks& tracks);
    void find_bodies(Tracks& tracks);
    void find_pockets(Tracks& tracks);
    void check_limit(std::uint64_t islands, std::uint64_t links) const;

    const SliceResult& stack_;
    const bool pockets_;
    const Context& context_;
    const Parallel parallel_;
    const Memory* const memory_;
    Array<TrackRing> rings_{memory_};        // of each contour
    Array<std::uint32_t> by_size_{memory_};  // from the first contour of each layer on
    Vector<TrackLayer> layers_{memory_};
    std::uint32_t islands_ = 0;
    std::uint32_t voids_ = 0;
    Vector<PairLinks> links_{memory_};  // of each layer but the last with the next
};

void TrackFinding::check_limit(std::uint64_t islands, std::uint64_t links) const {
    const std::uint64_t limit = detail::memory_limit(context_.memory_limit_bytes);
    const std::uint64_t bytes = islands * sizeof(Track) + links * (sizeof(TrackLink) + sizeof(std::uint32_t));
    if (bytes > limit || std::max(islands, links) >= no_track) {
        throw Refused{{ErrorCode::result_too_large, std::to_string(islands) + " islands with " + std::to_string(links) +
                                                        " links need more than the memory limit of " +
                                                        std::to_string(limit) + " bytes"}};
    }
}

void TrackFinding::number(Tracks& tracks) {
    const auto is_outer = [](const Contour& contour) { return contour.role == Role::outer; };
    const auto outers = std::count_if(stack_.contours.begin(), stack_.contours.end(), is_outer);
    if (stack_.contours.size() + stack_.size() >= no_track) {
        throw Refused{{ErrorCode::result_too_large, std::to_string(stack_.contours.size()) + " contours are too many"}};
    }
    check_limit(static_cast<std::uint64_t>(outers), 0);
    tracks.islands.resize_discarding(static_cast<std::uint64_t>(outers));
    rings_.resize_discarding(stack_.contours.size());
    by_size_.resize_discarding(stack_.contours.size());
    layers_.resize(stack_.size());
    for (std::size_t n = 0; n < layers_.size(); ++n) {
        parallel_.stop_if_asked();
        number(n, tracks);
    }
}

void TrackFinding::number(std::size_t n, Tracks& tracks) {
    const Layer& layer = stack_.layers[n];
    const std::span<const Contour> contours = stack_.contours_of(layer);
    const std::span<TrackRing> rings = rings_.span().subspan(layer.first_contour, contours.size());
    const std::span<std::uint32_t> by_size = by_size_.span().subspan(layer.first_contour, contours.size());
    TrackLayer& own = layers_[n];
    own.first_island = islands_;
    own.outside = voids_++;
    std::size_t count = 0;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        const Contour& contour = contours[c];
        TrackRing& ring = rings[c] = TrackRing();
        if (contour.role == Role::open) {
            throw Refused{{ErrorCode::invalid_argument, "layer " + std::to_string(n) +
                                                            " has an open contour, which bounds no island: close the mesh, "
                                                            "or slice with a longer stitch_mm"}};
        }
        ring.is_outer = contour.role == Role::outer;
        if (contour.role == Role::flat || (!ring.is_outer && islands_ == own.first_island)) {
            continue;
        }
        if (ring.is_outer) {
            tracks.islands[islands_++] = {.layer = n, .contour = layer.first_contour + c};
            const std::uint64_t parent =
                contour.parent < 0 ? c : static_cast<std::uint64_t>(contour.parent) - layer.first_contour;
            ring.empty = parent < c ? rings[parent].empty : own.outside;
        } else {
            ring.empty = voids_++;
        }
        ring.island = islands_ - 1;
        ring.points = stack_.points_of(contour);
        by_size[count++] = static_cast<std::uint32_t>(c);
    }
    own.islands = islands_ - own.first_island;
    own.rings = rings;
    own.by_size = by_size.first(count);
}

void TrackFinding::measure(std::size_t n, Tracks& tracks) {
    const TrackLayer& own = layers_[n];
    const std::uint64_t first = stack_.layers[n].first_contour;
    const auto by_size = by_size_.span().subspan(first, own.by_size.size());
    Worker worker(memory_, parallel_.stop());
    Vector<Moments> moments(own.islands, Moments(), memory_);
    for (const std::uint32_t r : by_size) {
        TrackRing& ring = rings_[first + r];
        ring.box = FlatBox::around(ring.points);
        require_on_grid(ring.box, n);
        moments[ring.island - own.first_island].add<false>(ring.points, stack_.contours[first + r].twice_area, {});
        worker.spend(ring.points.size());
    }
    const double grid_mm = stack_.info.grid_mm;
    for (std::uint32_t i = 0; i < own.islands; ++i) {
        Track& track = tracks.islands[own.first_island + i];
        const Point start = rings_[track.contour].points.front();
        const auto number = [](Word128 sum) { return static_cast<double>(static_cast<Int128>(sum)); };
        const double twice_area = std::max(number(moments[i].twice_area), 0.0);
        track.area_mm2 = twice_area / 2 * grid_mm * grid_mm;
        track.centroid_mm = {start.x * grid_mm, start.y * grid_mm};
        if (twice_area > 0) {
            track.centroid_mm = {number(moments[i].six_x) / (3 * twice_area) * grid_mm,
                                 number(moments[i].six_y) / (3 * twice_area) * grid_mm};
        }
    }
    sort_briefly(by_size.begin(), by_size.end(), [&](std::uint32_t a, std::uint32_t b) {
        worker.spend(1);
        const Contour& of_a = stack_.contours[first + a];
        const Contour& of_b = stack_.contours[first + b];
        if (const Int128 size = magnitude_of(of_a); size != magnitude_of(of_b)) {
            return size < magnitude_of(of_b);
        }
        return of_a.role != of_b.role ? of_a.role == Role::outer : a < b;
    });
}

void TrackFinding::link() {
    const std::size_t pairs = layers_.empty() ? 0 : layers_.size() - 1;
    links_.resize(pairs, PairLinks(memory_));
    std::vector<std::unique_ptr<Linker>> linkers(static_cast<std::size_t>(parallel_.threads()));
    parallel_.run_ranges(pairs, layers_a_task(), [&](std::size_t first, std::size_t last, int worker) {
        auto& linker = linkers[static_cast<std::size_t>(worker)];
        if (linker == nullptr) {
            linker = std::make_unique<Linker>(parallel_);
        }
        for (std::size_t n = first; n < last; ++n) {
            linker->links.run(layers_[n], layers_[n + 1], links_[n].islands, pockets_ ? &links_[n].voids : nullptr);
        }
    });
}

void TrackFinding::write(Tracks& tracks) {
    std::uint64_t count = 0;
    for (const PairLinks& links : links_) {
        count += links.islands.size();
    }
    check_limit(islands_, count);
    tracks.links.resize_discarding(count);
    tracks.links_by_upper.resize_discarding(count);
    TrackLink* out = tracks.links.data();
    for (const PairLinks& links : links_) {
        parallel_.stop_if_asked();
        out = std::copy(links.islands.begin(), links.islands.end(), out);
    }
    for (const TrackLink& link : tracks.links) {
        ++tracks.islands[link.lower].above;
        ++tracks.islands[link.upper].below;
    }
    std::uint32_t above = 0;
    std::uint32_t below = 0;
    for (Track& track : tracks.islands) {
        track.first_above = std::exchange(above, above + track.above);
        track.first_below = below;
        below += std::exchange(track.below, 0);
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        Track& upper = tracks.islands[tracks.links[i].upper];
        tracks.links_by_upper[upper.first_below + upper.below++] = i;
    }
    find_bodies(tracks);
}

void TrackFinding::find_bodies(Tracks& tracks) {
    SharedSets<std::uint32_t> sets(islands_, parallel_, memory_);
    for (const TrackLink& link : tracks.links) {
        sets.unite(link.lower, link.upper);
    }
    for (std::uint32_t i = 0; i < islands_; ++i) {
        const std::uint32_t root = sets.root(i);  // numbered before
        tracks.islands[i].body = root == i ? static_cast<std::uint32_t>(tracks.bodies++) : tracks.islands[root].body;
    }
}

void TrackFinding::find_pockets(Tracks& tracks) {
    Vector<TrackVoid> voids(voids_, TrackVoid(), memory_);
    for (std::size_t n = 0; n < layers_.size(); ++n) {
        const Layer& layer = stack_.layers[n];
        const double mm3 = (layer.top_mm - layer.bottom_mm) * stack_.info.grid_mm * stack_.info.grid_mm / 2;
        voids[layers_[n].outside].is_outside = true;
        for (const std::uint32_t r : layers_[n].by_size) {
            const Contour& contour = stack_.contours[layer.first_contour + r];
            TrackVoid& own = voids[layers_[n].rings[r].empty];
            own.twice_area =
                to_integer128(to_int128(own.twice_area) - to_int128(contour.twice_area));  // of a hole it is negative
            own.slab_mm3 = mm3;
            own.contour = contour.role == Role::hole ? layer.first_contour + r : own.contour;
        }
        parallel_.stop_if_asked();
    }
    Pockets pockets(voids, memory_);
    for (std::size_t n = 0; n < layers_.size(); ++n) {
        const std::uint32_t end = n + 1 < layers_.size() ? layers_[n + 1].outside : voids_;
        pockets.add_layer(end, n == 0 ? std::span<const TrackLink>() : std::span<const TrackLink>(links_[n - 1].voids));
        parallel_.stop_if_asked();
    }
    pockets.finish();
    tracks.pockets.resize_discarding(pockets.found().size());
    std::copy(pockets.found().begin(), pockets.found().end(), tracks.pockets.begin());
}

}  // namespace

Result<Tracks> find_tracks(const SliceResult& stack, const TrackOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<Tracks> { return TrackFinding(stack, options, context).find(); });
}

}  // namespace lamella
