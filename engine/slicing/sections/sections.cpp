// slice_sections(), as the list of its stages:
//
//     check        indices and coordinates, as slice() does; the box, and the grid that serves all frames
//     NearPlane    boxes around runs of triangles
//     cut          each plane by one thread: the triangles near it, sliced by themselves
//     join         one result

#include "lamella/sections.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/sort.hpp"
#include "base/vector.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/repair/polylines.hpp"
#include "slicing/sections/near_plane.hpp"
#include "slicing/slicer.hpp"

namespace lamella {

namespace {

/// One call.
class SectionCut {
public:
    SectionCut(const MeshView& mesh, std::span<const Transform> frames, const SliceOptions& options, const Context& context)
        : mesh_(mesh), frames_(frames), options_(options), context_(context), parallel_(context) {}

    SliceResult cut();

private:
    struct Cutter {
        explicit Cutter(const Memory* memory) : near(memory), soup(memory) {}
        Slicer slicer;
        Vector<std::size_t> near;
        Vector<std::byte> soup;
    };

    void choose_options();
    double farthest_in(const Transform& frame) const noexcept;
    void cut_one(std::size_t i, const NearPlane& mesh, Cutter& cutter);
    MeshView soup_of(Cutter& cutter) const;
    SliceResult join();

    const MeshView mesh_;
    const std::span<const Transform> frames_;
    SliceOptions options_;
    const Context& context_;
    const Parallel parallel_;
    Bounds bounds_ = Bounds::empty();
    std::vector<SliceResult> sections_;
};

SliceResult SectionCut::cut() {
    if (options_.content != LayerContent::section) {
        throw Refused{{ErrorCode::invalid_argument, "sections show what a plane cuts, not what faces project"}};
    }
    require(check_mesh(mesh_));
    BlockTable table(parallel_.memory());
    bounds_ = require(measure_bounds(mesh_, placing_of(mesh_, {}), options_.frame.grid_mm, parallel_, table));
    choose_options();
    parallel_.begin_stage(0.1);
    const NearPlane mesh(mesh_, bounds_, parallel_);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
        sections_.emplace_back(parallel_.memory());
    }
    std::vector<std::unique_ptr<Cutter>> cutters(parallel_.workers_for(frames_.size()));
    parallel_.begin_stage(0.95);
    parallel_.run(frames_.size(), [&](std::size_t i, int worker) {
        std::unique_ptr<Cutter>& own = cutters[static_cast<std::size_t>(worker)];
        if (own == nullptr) {
            own = std::make_unique<Cutter>(parallel_.memory());
        }
        cut_one(i, mesh, *own);
    });
    SliceResult joined = join();
    parallel_.finish();
    return joined;
}

/// One grid for all frames, and lengths that do not depend on what a plane meets.
void SectionCut::choose_options() {
    Bounds reach = Bounds::empty();
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
    options_.heights_mm = {0};
    options_.slabs.clear();
    options_.planes = {.side = options_.planes.side};
    options_.allow_empty = true;
    options_.stitch_mm = gap_length_mm(options_.stitch_mm, bounds_);
    if (!frames_.empty()) {
        options_.frame.grid_mm = require(choose_unit(reach, options_.frame.grid_mm, options_.frame.coarser_if_needed)).mm;
        options_.frame.coarser_if_needed = false;
    }
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

void SectionCut::cut_one(std::size_t i, const NearPlane& mesh, Cutter& cutter) {
    SliceOptions options = options_;
    options.frame.transform = frames_[i] * options_.frame.transform;
    PlaneReach plane;
    double largest = 0;  // of what is added up
    for (std::size_t axis = 0; axis < 4; ++axis) {
        plane.row[axis] = options.frame.transform.m[8 + axis];
        const double at = axis == 3 ? 1 : std::max(std::abs(bounds_.min_mm[axis]), std::abs(bounds_.max_mm[axis]));
        largest += std::abs(plane.row[axis]) * at;
    }
    // Vertex and plane are rounded to the grid; sums to doubles, or with as_mesh_numbers to floats.
    plane.room = 8 * options.frame.grid_mm + 0x1p-19 * largest;
    mesh.find(plane, cutter.near);
    sort_briefly(cutter.near.begin(), cutter.near.end());  // of equal ones the smallest index stands for all
    SliceResult& section = sections_[i];
    const Context one{.threads = 1,
                      .stop = parallel_.stop(),
                      .memory = context_.memory,
                      .memory_limit_bytes = context_.memory_limit_bytes};
    Result<SliceInfo> info = cutter.slicer.slice_to(Destination(section), soup_of(cutter), options, one);
    if (!info) {
        Error error = info.error();
        error.message = "section " + std::to_string(i) + ": " + error.message;
        throw Refused{std::move(error)};
    }
    for (PointOrigin& origin : section.origins) {
        if (origin.triangle != no_triangle) {
            origin.triangle = static_cast<std::uint32_t>(cutter.near[origin.triangle]);
        }
    }
}

/// The triangles near the plane, in the mesh's own numbers.
MeshView SectionCut::soup_of(Cutter& cutter) const {
    const std::size_t vertex_bytes = 3 * size_of(mesh_.vertex_type);
    cutter.soup.resize(3 * vertex_bytes * cutter.near.size());
    std::byte* to = cutter.soup.data();
    const auto copy_each = [&](auto bytes) {
        for (const std::size_t t : cutter.near) {
            for (std::size_t corner = 0; corner < 3; ++corner, to += bytes) {
                std::memcpy(to,
                            mesh_.indices != nullptr ? mesh_.vertex_at(mesh_.vertex_of(t, corner))
                                                     : mesh_.vertex_at(t) + corner * bytes,
                            bytes);
            }
        }
    };
    if (vertex_bytes == 12) {
        copy_each(std::integral_constant<std::size_t, 12>());
    } else {
        copy_each(std::integral_constant<std::size_t, 24>());
    }
    return {.vertices = cutter.soup.data(),
            .triangle_count = cutter.near.size(),
            .vertex_type = mesh_.vertex_type,
            .mm_per_unit = mesh_.mm_per_unit};
}

/// Layers, contours, points and the rest, one section after the other; counts added up.
SliceResult SectionCut::join() {
    SliceResult all(context_.memory);
    SliceInfo& info = all.info;
    info.options = options_;
    info.options.heights_mm->assign(frames_.size(), 0);
    info.grid_mm = options_.frame.grid_mm != 0 ? options_.frame.grid_mm : default_grid_mm;
    info.threads = parallel_.threads();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        info.box.min_mm[axis] = bounds_.min_mm[axis];
        info.box.max_mm[axis] = bounds_.max_mm[axis];
    }
    std::size_t origins = 0;
    for (std::size_t i = 0; i < sections_.size(); ++i) {
        info.layer_of.push_back(i);
        const SliceInfo& own = sections_[i].info;
        info.segments += own.segments;
        origins += sections_[i].origins.size();
#define END_COUNTER(name) info.name += own.name;
#include "options/counters.inc"
    }
    info.triangles = mesh_.triangle_count;
    info.layers = info.planned_layers = sections_.size();
    all.layers.resize_discarding(sections_.size());
    all.contours.resize_discarding(info.contours);
    all.points.resize_discarding(info.points);
    all.origins.resize_discarding(origins);
    all.stitches.resize_discarding(info.stitches);
    Contour* contour = all.contours.data();
    Point* point = all.points.data();
    PointOrigin* origin = all.origins.data();
    Stitch* stitch = all.stitches.data();
    for (std::size_t i = 0; i < sections_.size(); ++i) {
        const SliceResult& own = sections_[i];
        const auto first_contour = static_cast<std::uint64_t>(contour - all.contours.data());
        const auto first_point = static_cast<std::uint64_t>(point - all.points.data());
        all.layers[i] = own.layers[0];
        all.layers[i].first_contour = first_contour;
        for (Contour moved : own.contours) {
            moved.first_point += first_point;
            moved.parent += moved.parent < 0 ? 0 : static_cast<std::int64_t>(first_contour);
            *contour++ = moved;
        }
        point = std::copy(own.points.begin(), own.points.end(), point);
        origin = std::copy(own.origins.begin(), own.origins.end(), origin);
        for (Stitch joint : own.stitches) {
            joint.layer = i;
            *stitch++ = joint;
        }
    }
    return all;
}

}  // namespace

Result<SliceResult> slice_sections(const MeshView& mesh, std::span<const Transform> frames, const SliceOptions& options,
                                   const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceResult> { return SectionCut(mesh, frames, options, context).cut(); });
}

}  // namespace lamella
