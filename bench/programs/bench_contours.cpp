// assemble() and nesting alone: on each case's largest layer, and nesting on layers of 10 to 10,000 contours.
#include <algorithm>
#include <cstring>
#include <vector>

#include "base/numbers.hpp"
#include "base/rounding.hpp"
#include "lamella/assemble.hpp"
#include "measure.hpp"
#include "slicing/contours/mesh_edge.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella::bench {

namespace {

// --- assemble()

Point pierce(const GridVertex& lower, const GridVertex& upper, std::int32_t z) {
    const double rise = static_cast<double>(upper.z) - lower.z;
    const double slope_x = (static_cast<double>(upper.x) - lower.x) / rise;
    const double slope_y = (static_cast<double>(upper.y) - lower.y) / rise;
    const double up = static_cast<double>(z) - lower.z;
    return {round_to_int(lower.x + slope_x * up), round_to_int(lower.y + slope_y * up)};
}

/// The plane's segments as a caller would pass them. Ranks are omitted: no case has edges of more than two faces.
std::vector<Segment> segments_of(const Stages& stages, PlaneIndex plane) {
    std::vector<Segment> segments;
    const std::int32_t z = stages.planes().z(plane);
    const Buckets& buckets = stages.buckets();
    for (std::uint32_t r = 0; r < buckets.list_begin[plane + 1]; ++r) {
        const CrossedTriangle& t = buckets.records[r];
        if (t.last <= plane) {
            continue;
        }
        const bool above = t.middle_plane() <= plane;
        const GridVertex& low = above ? t.middle : t.lower;
        const GridVertex& high = above ? t.upper : t.middle;
        Segment segment{to_key(long_edge(t)), to_key(short_edge(t, above)), pierce(t.lower, t.upper, z),
                        pierce(low, high, z)};
        if (!t.long_edge_is_source()) {
            std::swap(segment.from_key, segment.to_key);
            std::swap(segment.from, segment.to);
        }
        segments.push_back(segment);
    }
    return segments;
}

bool same_layer(const LayerContours& found, const SliceResult& result, const Layer& layer) {
    if (found.contours.size() != layer.contour_count) {
        return false;
    }
    for (std::size_t c = 0; c < found.contours.size(); ++c) {
        const Contour& a = found.contours[c];
        const Contour& b = result.contours_of(layer)[c];
        const std::int64_t parent = b.parent < 0 ? -1 : b.parent - static_cast<std::int64_t>(layer.first_contour);
        if (a.point_count != b.point_count || a.segments != b.segments || a.role != b.role || a.parent != parent ||
            !(a.twice_area == b.twice_area) ||
            !std::equal(result.points_of(b).begin(), result.points_of(b).end(), found.points.data() + a.first_point)) {
            return false;
        }
    }
    return true;
}

void run_assemble(benchmark::State& state, Prepared& prepared, int threads) {
    std::string failure = prepared.check(ContourForm::swept, threads);
    const Stages* stages = failure.empty() ? prepared.stages(threads) : nullptr;
    if (stages == nullptr) {
        state.SkipWithError(failure.empty() ? "a stage failed" : failure.c_str());
        return;
    }
    const auto& counts = stages->buckets().segments;
    const auto plane = static_cast<PlaneIndex>(std::max_element(counts.begin(), counts.end()) - counts.begin());
    const std::vector<Segment> segments = segments_of(*stages, plane);
    const Control control{.threads = threads};
    const Result<LayerContours> once = assemble(segments, control);
    if (!once || !same_layer(*once, prepared.result, prepared.result.layers[plane])) {
        state.SkipWithError("assemble() and slice() disagree");
        return;
    }
    const double seconds = measure(state, [&] { benchmark::DoNotOptimize(assemble(segments, control)); });
    count(state,
          {.segments = segments.size(),
           .bytes = segments.size() * sizeof(Segment) + once->points.size() * sizeof(Point) +
                    once->contours.size() * sizeof(Contour)},
          seconds, threads);
}

// --- Nesting

/// Resets what nesting writes into an item.
void forget(std::vector<NestItem>& items) {
    for (NestItem& item : items) {
        item.flags = 0;
        item.parent = -1;
    }
}

std::vector<NestItem> items_of(const SliceResult& result, const Layer& layer) {
    std::vector<NestItem> items;
    for (const Contour& contour : result.contours_of(layer)) {
        const std::span<const Point> points = result.points_of(contour);
        NestItem& item = items.emplace_back();
        item.points = points.data();
        item.count = contour.point_count;
        const Int128 area = to_int128(contour.twice_area);
        item.twice_area = to_integer128((area < 0) == (contour.orientation < 0) ? area : -area);
        item.closed = contour.role != Role::open;
        item.box = FlatBox::around(points);
    }
    return items;
}

/// Times nesting of the layer with the most contours, in the order in which slice() stored them.
void run_nesting(benchmark::State& state, Prepared& prepared) {
    if (const std::string failure = prepared.check(ContourForm::swept, 1); !failure.empty()) {
        state.SkipWithError(failure.c_str());
        return;
    }
    const SliceResult& result = prepared.result;
    const Layer& layer = *std::max_element(result.layers.begin(), result.layers.end(),
                                           [](const Layer& a, const Layer& b) { return a.contour_count < b.contour_count; });
    std::vector<NestItem> items = items_of(result, layer);
    lamella::Worker worker;
    Nester nester(worker);
    nester.nest(items);
    for (std::size_t c = 0; c < items.size(); ++c) {
        const Contour& known = result.contours_of(layer)[c];
        const std::int64_t parent = known.parent < 0 ? -1 : known.parent - static_cast<std::int64_t>(layer.first_contour);
        if (items[c].parent != parent || items[c].role != known.role) {
            state.SkipWithError("nesting alone and slice() disagree");
            return;
        }
    }
    const double seconds = measure(
        state, [&] { forget(items); }, [&] { nester.nest(items); });
    count(state, {.segments = layer.segments, .contours = items.size()}, seconds, 1);
}

/// `count` rings on a square lattice. Every second ring is the hole of the ring before it.
class RingLattice {
public:
    explicit RingLattice(std::uint32_t count) {
        points_.reserve(std::size_t{count} * ring_points);
        std::uint32_t row = 1;
        while (row * row * 2 < count) {
            ++row;
        }
        for (std::uint32_t i = 0; i < count; ++i) {
            const bool hole = i % 2 == 1;
            const std::uint32_t cell = i / 2;
            add_ring(static_cast<std::int32_t>(cell % row) * pitch, static_cast<std::int32_t>(cell / row) * pitch,
                     hole ? side / 2 : side, hole);
        }
    }
    std::vector<NestItem>& items() noexcept { return items_; }

    /// Outers have no parent; the parent of a hole is its outer.
    bool nested() const noexcept {
        for (std::size_t i = 0; i < items_.size(); ++i) {
            const bool hole = i % 2 == 1;
            if (items_[i].parent != (hole ? static_cast<std::int64_t>(i) - 1 : -1) ||
                items_[i].role != (hole ? Role::hole : Role::outer)) {
                return false;
            }
        }
        return true;
    }

private:
    static constexpr std::int32_t steps = 16;  // points on each side
    static constexpr std::uint32_t ring_points = 4 * steps;
    static constexpr std::int32_t side = 64 * steps;
    static constexpr std::int32_t pitch = 2 * side;

    /// A square from its lower left corner, counter-clockwise; clockwise for a hole.
    void add_ring(std::int32_t centre_x, std::int32_t centre_y, std::int32_t length, bool hole) {
        const Point* ring = points_.data() + points_.size();
        const Point low{centre_x - length / 2, centre_y - length / 2};
        for (std::int32_t i = 0; i < 4 * steps; ++i) {
            const std::int32_t along = i % steps * (length / steps);
            const Point right[] = {{along, 0}, {length, along}, {length - along, length}, {0, length - along}};
            const Point& at = right[i / steps];
            points_.push_back(hole ? Point{low.x + at.y, low.y + at.x} : Point{low.x + at.x, low.y + at.y});
        }
        NestItem& item = items_.emplace_back();
        item.points = ring;
        item.count = ring_points;
        item.twice_area = to_integer128((hole ? -2 : 2) * Int128{length} * length);
        item.box = {low, {low.x + length, low.y + length}};
        item.closed = true;
    }

    std::vector<Point> points_;
    std::vector<NestItem> items_;
};

void run_nesting_series(benchmark::State& state, std::uint32_t contours) {
    RingLattice lattice(contours);
    lamella::Worker worker;
    Nester nester(worker);
    nester.nest(lattice.items());
    if (!lattice.nested()) {
        state.SkipWithError("the rings are not nested as constructed");
        return;
    }
    const double seconds = measure(
        state, [&] { forget(lattice.items()); }, [&] { nester.nest(lattice.items()); });
    count(state, {.contours = contours}, seconds, 1);
}

}  // namespace

void add_contours(const Options& options, const Case& wanted) {
    const bool few_planes = wanted.name.find("_planes") != std::string::npos;
    if (!wanted.measured.stages && !few_planes) {
        return;
    }
    for (const int threads : thread_counts(options)) {
        add_case_benchmark(benchmark_name("assemble", wanted.name, "largest_layer", threads), options, wanted,
                           [=](benchmark::State& state, Prepared& p) { run_assemble(state, p, threads); });
    }
    add_case_benchmark(benchmark_name("nesting", wanted.name, "most_contours", 1), options, wanted, run_nesting);
}

void add_nesting_series(const Options& options) {
    for (const std::uint32_t contours : {10U, 100U, 1'000U, 10'000U}) {
        add_benchmark(benchmark_name("nesting", "rings_" + std::to_string(contours), "series", 1), options,
                      [=](benchmark::State& state) { run_nesting_series(state, contours); });
    }
}

}  // namespace lamella::bench
