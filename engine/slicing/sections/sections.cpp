// slice_sections(), as the list of its stages:
//
//     check        indices and coordinates, as slice() does; the box, and the grid that serves all frames
//     NearPlane    boxes around runs of triangles
//     cut          each plane by one thread, as a band of one layer: the triangles near it, and their contours
//     finish       layers to their place

#include "lamella/sections.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "slicing/buckets/thread_shares.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/sections/near_plane.hpp"
#include "slicing/slice_layers.hpp"
#include "slicing/sweep/band_sweep.hpp"

namespace lamella {

namespace {

/// One call.
class SectionCut {
public:
    SectionCut(const MeshView& mesh, std::span<const Transform> frames, const SliceOptions& options, const Context& context)
        : mesh_(mesh), frames_(frames), options_(options), context_(context), parallel_(context) {}

    SliceResult cut();

private:
    /// What a thread cuts with.
    struct Cutter {
        explicit Cutter(const Memory* memory) : near(memory), buckets(memory), sweep(memory, instruction_set()) {}
        Vector<std::size_t> near;
        Buckets buckets;  ///< of one plane
        BandSweep sweep;
    };

    void check();
    Bounds reach_of_frames() const;
    double farthest_in(const Transform& frame) const noexcept;
    void begin(SliceInfo& info);
    void cut_all(const NearPlane& mesh, SliceResult& sections);
    void cut_one(std::size_t i, const NearPlane& mesh, Cutter& cutter, BandOutput& output);
    void find_crossed(const Frame& frame, Cutter& cutter) const;
    void count_bytes(const BandOutput& output);

    const MeshView mesh_;
    const std::span<const Transform> frames_;
    SliceOptions options_;  ///< with the plane z = 0
    const Context& context_;
    const Parallel parallel_;
    const std::uint64_t limit_ = detail::memory_limit(context_.memory_limit_bytes);
    Bounds bounds_ = Bounds::empty();
    double unit_mm_ = default_grid_mm;
    PlaneSet plane_{parallel_.memory()};  ///< z = 0
    LayerRules rules_{};
    Array<std::uint64_t> segments_{parallel_.memory()};
    std::atomic<std::uint64_t> bytes_ = 0;  ///< that sections take
};

SliceResult SectionCut::cut() {
    check();
    SliceResult sections(context_.memory);
    begin(sections.info);
    parallel_.begin_stage(0.1);
    const NearPlane mesh(mesh_, bounds_, parallel_);
    parallel_.begin_stage(0.95);
    cut_all(mesh, sections);
    parallel_.finish();
    return sections;
}

void SectionCut::check() {
    if (options_.content != LayerContent::section) {
        throw Refused{{ErrorCode::invalid_argument, "sections show what a plane cuts, not what faces project"}};
    }
    options_.heights_mm = {0};
    options_.slabs.clear();
    options_.planes = {.side = options_.planes.side};
    check_options(options_, {});
    require(check_mesh(mesh_));
    BlockTable table(parallel_.memory());
    bounds_ = require(measure_bounds(mesh_, placing_of(mesh_, {}), options_.frame.grid_mm, parallel_, table));
}

/// One grid for all frames, and lengths that do not depend on what a plane meets.
void SectionCut::begin(SliceInfo& info) {
    Frame& frame = options_.frame;
    SharedFrame shared{reach_of_frames(), {frame.grid_mm > 0 ? frame.grid_mm : default_grid_mm, 0}, Number::f64};
    if (!frames_.empty()) {
        shared.unit = require(choose_unit_for(shared.bounds, frame.grid_mm, frame.coarser_if_needed, options_.region));
    }
    unit_mm_ = shared.unit.mm;
    begin_info(options_, bounds_, shared.unit, info);
    plane_.build(options_, {}, shared, limit_);
    rules_ = rules_for(options_, info);
    info.options.heights_mm->assign(frames_.size(), 0);
    info.layer_of.resize(frames_.size());
    std::iota(info.layer_of.begin(), info.layer_of.end(), 0);
    info.layers = info.planned_layers = frames_.size();
    info.triangles = mesh_.triangle_count;
    info.threads = parallel_.threads();
}

Bounds SectionCut::reach_of_frames() const {
    Bounds reach = frames_.empty() ? Bounds{} : Bounds::empty();
    for (std::size_t i = 0; i < frames_.size(); ++i) {
        const Transform& frame = frames_[i];
        if (!std::all_of(frame.m.begin(), frame.m.end(), [](double number) { return std::isfinite(number); })) {
            throw Refused{{ErrorCode::invalid_argument,
                           "section " + std::to_string(i) + ": its frame has a number that is not finite"}};
        }
        require(check_transform(frame * options_.frame.transform));
        const double farthest = farthest_in(frame);
        for (int axis = 0; axis < 3; ++axis) {
            reach.add(axis, -farthest, farthest);
        }
    }
    return reach;
}

/// The largest coordinate of the corners of the mesh's box.
double SectionCut::farthest_in(const Transform& frame) const noexcept {
    const Transform placed = frame * options_.frame.transform;
    double farthest = 0;
    for (std::size_t row = 0; row < 12; row += 4) {
        double low = placed.m[row + 3];
        double high = low;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double a = placed.m[row + axis] * bounds_.min_mm[axis];
            const double b = placed.m[row + axis] * bounds_.max_mm[axis];
            low += std::min(a, b);
            high += std::max(a, b);
        }
        farthest = std::max({farthest, std::abs(low), std::abs(high)});
    }
    return farthest;
}

void SectionCut::cut_all(const NearPlane& mesh, SliceResult& sections) {
    std::vector<Band> bands;
    for (PlaneIndex i = 0; i < frames_.size(); ++i) {
        bands.push_back({i, i + 1, 0});
    }
    segments_.resize_discarding(frames_.size());
    OutputScratch scratch(parallel_.memory());
    const auto layer_at = [this](PlaneIndex i) { return describe_layer(plane_, 0, segments_[i]); };
    const OutputPlan plan{.layers = static_cast<PlaneIndex>(bands.size()),
                          .layer_at = layer_at,
                          .segments = 0,  // not known
                          .cutting = 0,
                          .bands = bands,
                          .parallel = parallel_,
                          .scratch = scratch,
                          .origins = options_.origins,
                          .info = sections.info};
    ResultTarget target(sections);
    target.admit(plan, limit_);
    target.begin(plan);
    std::vector<std::unique_ptr<Cutter>> cutters(parallel_.workers_for(bands.size()));
    fill_bands(target, parallel_, 0, bands.size(), [&](std::size_t i, int worker, BandOutput& output) {
        std::unique_ptr<Cutter>& own = cutters[static_cast<std::size_t>(worker)];
        if (own == nullptr) {
            own = std::make_unique<Cutter>(parallel_.memory());
            own->sweep.set_rules(rules_);
        }
        try {
            cut_one(i, mesh, *own, output);
        } catch (Refused& refused) {
            refused.error.message = "section " + std::to_string(i) + ": " + refused.error.message;
            throw;
        }
        count_bytes(output);
    });
    cutters.clear();
    sections.info.segments = std::accumulate(segments_.begin(), segments_.end(), std::uint64_t{0});
    target.finish();
}

void SectionCut::cut_one(std::size_t i, const NearPlane& mesh, Cutter& cutter, BandOutput& output) {
    Frame frame = options_.frame;
    frame.transform = frames_[i] * options_.frame.transform;
    PlaneReach plane;
    double largest = 0;  // of what is added up
    for (std::size_t axis = 0; axis < 4; ++axis) {
        plane.row[axis] = frame.transform.m[8 + axis];
        const double at = axis == 3 ? 1 : std::max(std::abs(bounds_.min_mm[axis]), std::abs(bounds_.max_mm[axis]));
        largest += std::abs(plane.row[axis]) * at;
    }
    // Vertex and plane are rounded to the grid; sums to doubles, or with as_mesh_numbers to floats.
    plane.room = 8 * unit_mm_ + 0x1p-19 * largest;
    mesh.find(plane, cutter.near);
    find_crossed(frame, cutter);
    segments_[i] = cutter.buckets.segment_count;
    cutter.sweep.run({0, 1, segments_[i]}, {}, cutter.buckets, plane_, ContourForm::swept, parallel_.stop(), output);
}

/// The list of the one plane, of the triangles near it.
void SectionCut::find_crossed(const Frame& frame, Cutter& cutter) const {
    Buckets& buckets = cutter.buckets;
    buckets.records.resize_discarding(cutter.near.size());
    buckets.lowest_corners.resize_discarding(options_.origins ? cutter.near.size() : 0);
    std::uint32_t count = 0;
    with_reader(mesh_, placing_of(mesh_, frame), unit_mm_, [&](const auto& read) {
        for (const std::size_t t : cutter.near) {
            const RoundedTriangle triangle{read(t), t, plane_};
            if (triangle.planes().size() == 0 || triangle.is_degenerate()) {
                continue;
            }
            const std::uint8_t lowest = triangle.write(buckets.records[count], 1);
            if (options_.origins) {
                buckets.lowest_corners[count] = lowest;
            }
            ++count;
        }
    });
    buckets.list_begin.resize_discarding(2);
    buckets.list_begin[0] = 0;
    buckets.list_begin[1] = count;
    buckets.segments.resize_discarding(1);
    buckets.segments[0] = count;
    buckets.segment_count = count;
}

/// Whether all sections together exceed the limit does not depend on their order.
void SectionCut::count_bytes(const BandOutput& output) {
    if (bytes_ += output.bytes_used(); bytes_ > limit_) {
        throw Refused{{ErrorCode::result_too_large,
                       "the sections need more than the memory limit of " + std::to_string(limit_) + " bytes"}};
    }
}

}  // namespace

Result<SliceResult> slice_sections(const MeshView& mesh, std::span<const Transform> frames, const SliceOptions& options,
                                   const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceResult> { return SectionCut(mesh, frames, options, context).cut(); });
}

}  // namespace lamella
