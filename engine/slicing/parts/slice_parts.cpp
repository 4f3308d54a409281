// Slicing several meshes, as the list of its stages:
//
//     choose_frame       the box of all parts, and from it one grid and one set of planes
//     list_copies        what is cut: a part once for all of its places that are at one height
//     slice_all          each cut by itself: many small ones side by side, others by all threads
//     label_objects      contours by roles, where parts have some
//     merge_parts        contours of all parts, side by side in each layer, or one region of them

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/words.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/prepared_source.hpp"
#include "slicing/parts/copies.hpp"
#include "slicing/parts/merge_parts.hpp"
#include "slicing/parts/roles.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

/// What a part is cut from: a prepared mesh, where it is not null, or the mesh.
struct PartMesh {
    explicit PartMesh(const Part& part) noexcept
        : prepared(part.prepared == nullptr ? nullptr : Source(*part.prepared).prepared()),
          mesh(prepared == nullptr ? part.mesh : prepared->mesh) {}

    const detail::PreparedImpl* prepared;
    const MeshView& mesh;
};

/// As asked; of parts with roles each is a region.
SliceOptions options_of_parts(const SliceOptions& asked, bool have_roles) {
    SliceOptions options = asked;
    if (have_roles) {
        const auto make_region = [](FillRule& rule) { rule = rule == FillRule::contours ? FillRule::non_zero : rule; };
        make_region(options.region.fill_rule);
        for (FillFrom& from : options.region.fill_from) {
            make_region(from.rule);
        }
    }
    return options;
}

/// What counts against the limit on memory, once a part is sliced.
std::uint64_t bytes_of(const SliceResult& part) noexcept {
    return part.points.size() * sizeof(Point) + part.contours.size() * sizeof(Contour) +
           part.origins.size() * sizeof(PointOrigin);
}

/// The most that may count before: see ResultTarget::admit().
std::uint64_t most_counted(const SliceInfo& part) noexcept {
    return part.segments * (sizeof(Point) + sizeof(PointOrigin)) +
           part.layers * (sizeof(Layer) + sizeof(Contour) + sizeof(std::uint64_t)) +
           part.layer_of.size() * sizeof(std::uint64_t);
}

void throw_first(std::vector<std::optional<Error>>& errors) {
    for (std::optional<Error>& error : errors) {
        if (error) {
            throw Refused{std::move(*error)};
        }
    }
}

class PartSlicing {
public:
    PartSlicing(std::span<const Part> parts, const SliceCall& call)
        : parts_(parts),
          call_(call),
          have_roles_(have_roles(parts)),
          options_(options_of_parts(call.options, have_roles_)),
          parallel_(*call.kept.parallel),
          progress_(call.context.progress) {
        if (parts.empty()) {
            throw Refused{{ErrorCode::invalid_argument, "there are no parts to slice"}};
        }
        check_places(parts, options_);
        check_roles(parts);
        if (options_.origins && have_roles_) {
            throw Refused{{ErrorCode::invalid_argument, "parts with roles have no origins, since they cut each other"}};
        }
        if (options_.unite_parts) {
            require(check_every_layer(call.options.region, "uniting parts"));
        }
    }

    void slice(LayerTarget* target, SliceInfo& info) {
        choose_frame();
        const Bounds box = frame_.bounds;
        slice_all(box, target, info);
        if (info.degenerate == info.triangles) {
            frame_.bounds = {};  // the box of nothing must not choose planes
            slice_all(box, target, info);
        }
        if (target == nullptr) {
            return;
        }
        const auto start = Clock::now();
        layers_ = layers_of(parts_, list_, sliced_);
        const auto labelled = label_objects(parts_, list_.first_copy, layers_, parallel_.within(call_.context));
        if (options_.share_copies) {
            info.copies = leave_first(list_, layers_);
        }
        const auto reach = [this](double share) { progress_.reach(sliced_share() + (0.99 - sliced_share()) * share); };
        merge_parts({.layers = planned_, .parts = layers_, .are_repeated = layers_.size() > list_.cuts.size()}, call_,
                    *target, info, reach);
        (makes_regions() ? info.ms.fill : info.ms.contours) += milliseconds_since(start);
        progress_.finish();
    }

private:
    bool makes_regions() const noexcept { return have_roles_ || options_.unite_parts; }
    /// The progress when all parts are sliced.
    double sliced_share() const noexcept { return makes_regions() ? 0.5 : 0.95; }

    void choose_frame();
    std::vector<Bounds> measure_all();
    void check_prepared(std::size_t p) const;
    void slice_all(const Bounds& box, LayerTarget* target, SliceInfo& info);
    bool are_many_small() const noexcept;
    bool slice_side_by_side(bool whole);
    void slice_one_by_one(bool whole);
    void slice_cut(std::size_t c, bool whole, const Context& context, detail::SlicerImpl& kept);
    PartMesh mesh_of(std::size_t cut) const noexcept { return PartMesh(parts_[list_.cuts[cut].part]); }
    double share_of(std::uint64_t triangles) const noexcept {
        return sliced_share() * static_cast<double>(triangles) / static_cast<double>(std::max<std::uint64_t>(1, triangles_));
    }

    std::span<const Part> parts_;
    const SliceCall& call_;
    bool have_roles_;
    SliceOptions options_;
    const Parallel& parallel_;
    ProgressMeter progress_;
    SharedFrame frame_{};
    std::uint64_t triangles_ = 0;  ///< of all cuts
    CopyList list_;
    std::vector<SliceResult> sliced_;           ///< by cut
    std::vector<PartLayers> layers_;            ///< of sliced_, by copy
    Vector<Layer> planned_{call_.kept.memory};  ///< without contours
};

void PartSlicing::choose_frame() {
    const std::vector<Bounds> bounds = measure_all();
    Bounds all = Bounds::empty();
    Number number = Number::f32;
    Frame asked = options_.frame;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        const PartMesh of(parts_[p]);
        if (options_.allow_empty && of.mesh.triangle_count == 0) {
            continue;
        }
        triangles_ += of.mesh.triangle_count;
        all.add(bounds[p]);
        Number own = of.prepared != nullptr
                         ? of.prepared->frame.number
                         : placed_number(of.mesh, placing_of(of.mesh, options_.frame, parts_[p].placement));
        for (const auto& move : moves_mm(parts_, p, options_.frame.transform)) {
            all.add(moved(bounds[p], move));
            own = move[2] != 0 ? Number::f64 : own;
        }
        number = own == Number::f64 ? own : number;
        if (of.prepared != nullptr && asked.grid_mm == 0) {
            asked.grid_mm = of.prepared->asked.grid_mm;
        }
    }
    frame_ = lamella::choose_frame(triangles_ == 0 ? Bounds{} : all, number, asked, options_.region);
    list_ = list_copies(parts_, options_.frame.transform, frame_.unit.mm);
    if (triangles_ > 0) {
        frame_.bounds = box_of_copies(parts_, bounds, list_, frame_.unit.mm);
    }
    triangles_ = 0;
    for (std::size_t c = 0; c < list_.cuts.size(); ++c) {
        triangles_ += mesh_of(c).mesh.triangle_count;
    }
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        check_prepared(p);
    }
}

/// Empty where a part has no triangles.
std::vector<Bounds> PartSlicing::measure_all() {
    std::vector<Bounds> bounds(parts_.size(), Bounds::empty());
    std::vector<std::optional<Error>> errors(parts_.size());
    const auto measure = [&](std::size_t p, const Parallel& parallel, BlockTable& table) {
        const PartMesh of(parts_[p]);
        if (options_.allow_empty && of.mesh.triangle_count == 0) {
            return;
        }
        const Placing placing = placing_of(of.mesh, options_.frame, parts_[p].placement);
        Result<Bounds> own = of.prepared != nullptr
                                 ? of.prepared->bounds
                                 : measure_bounds(of.mesh, placing, options_.frame.grid_mm, parallel, table);
        if (own) {
            bounds[p] = *own;
        } else {
            errors[p] = blamed_on_part(own.error(), p);
        }
    };
    if (are_many_small()) {
        call_.kept.sides.resize(static_cast<std::size_t>(parallel_.threads()));
        parallel_.run(parts_.size(), [&](std::size_t p, int worker) {
            detail::SlicerImpl& side = call_.kept.side_of(worker);
            measure(p, *side.parallel, side.buckets.blocks);
        });
    } else {
        BlockTable table(parallel_.memory());
        for (std::size_t p = 0; p < parts_.size() && (p == 0 || !errors[p - 1]); ++p) {
            measure(p, parallel_, table);
        }
    }
    throw_first(errors);
    return bounds;
}

/// Throws Refused where a part was not prepared for the frame of all.
void PartSlicing::check_prepared(std::size_t p) const {
    const detail::PreparedImpl* const prepared = PartMesh(parts_[p]).prepared;
    if (prepared == nullptr) {
        return;
    }
    if (prepared->frame.unit.mm != frame_.unit.mm) {
        throw Refused{refusal_of(p, "it was prepared on a grid of " + exact_text(prepared->frame.unit.mm) +
                                        " mm, and all parts need one of " + exact_text(frame_.unit.mm) +
                                        " mm: prepare it on that one")};
    }
    Frame frame = options_.frame;
    frame.grid_mm = 0;  // just checked
    frame.transform = frame.transform * parts_[p].placement;
    try {
        (void)prepared->frame_for(frame);
    } catch (Refused& refused) {
        throw Refused{refusal_of(p, refused.error.message)};
    }
}

/// Once the target has admitted what the frame says of the whole. Without a target, parts are counted only.
void PartSlicing::slice_all(const Bounds& box, LayerTarget* target, SliceInfo& info) {
    begin_info(options_, box, frame_.unit, info);
    build_planes(call_, frame_, call_.kept.planes);
    describe_plan(call_.kept.planes, call_.tuning.random_heights.has_value(), info);
    planned_.clear();
    for (PlaneIndex l = 0; l < info.layers; ++l) {
        planned_.push_back(describe_layer(call_.kept.planes, l, 0));
    }
    info.options.stitch_mm = 0;
    info.part_count = list_.copies.size();
    info.threads = parallel_.threads();
    if (target != nullptr) {
        target->admit_layers(info.layers, info);
    }
    if (!are_many_small() || !slice_side_by_side(target != nullptr)) {
        slice_one_by_one(target != nullptr);
    }
    for (std::size_t c = 0; c < sliced_.size(); ++c) {
        info.options.stitch_mm = std::max(info.options.stitch_mm, sliced_[c].info.options.stitch_mm);
        add_work(sliced_[c].info, options_.share_copies ? 1 : list_.cuts[c].copies, info);
    }
}

/// Then a part keeps no two threads busy.
bool PartSlicing::are_many_small() const noexcept {
    constexpr std::size_t most_triangles = 1 << 16;
    return parallel_.threads() > 1 &&
           std::max(parts_.size(), list_.cuts.size()) >= 2 * static_cast<std::size_t>(parallel_.threads()) &&
           std::all_of(parts_.begin(), parts_.end(),
                       [](const Part& part) { return PartMesh(part).mesh.triangle_count <= most_triangles; });
}

/// Each by one thread. False where the limit on memory might not hold all: what is refused then must not depend on threads.
/// Of several parts that fail the first one speaks, as it does one by one.
bool PartSlicing::slice_side_by_side(bool whole) {
    sliced_.clear();
    for (std::size_t c = 0; c < list_.cuts.size(); ++c) {
        sliced_.emplace_back(call_.kept.memory);
    }
    const std::uint64_t limit = call_.context.memory_limit_bytes;
    std::atomic<std::uint64_t> triangles = 0;
    std::atomic<std::uint64_t> bytes = 0;  // that results take
    std::vector<std::optional<Error>> errors(list_.cuts.size());
    std::atomic<bool> failed = false;
    const Context context{.memory = call_.context.memory, .memory_limit_bytes = limit};
    call_.kept.sides.resize(static_cast<std::size_t>(parallel_.threads()));
    parallel_.run(list_.cuts.size(), [&](std::size_t c, int worker) {
        if (failed || (limit != 0 && bytes > limit)) {
            return;  // parts before have begun
        }
        try {
            slice_cut(c, whole, context, call_.kept.side_of(worker));
        } catch (Refused& refused) {
            errors[c] = std::move(refused.error);
            failed = true;
            return;
        }
        bytes += bytes_of(sliced_[c]);
        progress_.reach(share_of(triangles += mesh_of(c).mesh.triangle_count));
    });
    std::uint64_t most = 0;  // that one part may be refused for
    for (const SliceResult& part : sliced_) {
        most = std::max(most, most_counted(part.info));
    }
    if (limit != 0 && (failed || bytes + most > limit)) {
        return false;
    }
    throw_first(errors);
    return true;
}

/// Each by all threads, and within what those before leave of the limit that was asked for; where none was, each has its
/// own.
void PartSlicing::slice_one_by_one(bool whole) {
    sliced_.clear();
    std::uint64_t before = 0;  // triangles of the parts before
    Context context = call_.context;
    for (std::size_t c = 0; c < list_.cuts.size(); ++c) {
        const std::uint64_t own = mesh_of(c).mesh.triangle_count;
        auto report = [&](double fraction) noexcept { progress_.reach(share_of(before) + share_of(own) * fraction); };
        context.progress = report;
        sliced_.emplace_back(call_.kept.memory);
        slice_cut(c, whole, context, call_.kept);
        const std::uint64_t bytes = bytes_of(sliced_[c]);
        std::uint64_t& left = context.memory_limit_bytes;
        left = left > bytes ? left - bytes : std::min<std::uint64_t>(left, 1);
        before += own;
    }
}

/// In the frame of all.
void PartSlicing::slice_cut(std::size_t c, bool whole, const Context& context, detail::SlicerImpl& kept) {
    SliceOptions options = options_;
    if (options_.unite_parts) {  // other rules come after; only roles need regions of each part
        options.region = {};
        if (have_roles_) {
            options.region.fill_rule = options_.region.fill_rule;
            options.region.fill_from = options_.region.fill_from;
        }
    }
    const std::size_t p = list_.cuts[c].part;
    const PartMesh of(parts_[p]);
    SharedFrame frame = frame_;
    frame.raised = list_.cuts[c].up;
    SliceResult& own = sliced_[c];
    ResultTarget result(own);
    LayerTarget* const target = whole ? &result : nullptr;
    const SliceCall call{options, call_.tuning, context, kept};
    try {
        if (of.prepared != nullptr) {
            PreparedSource source(*of.prepared, frame, kept.source_tools());
            slice_layers(source, target, call, own.info);
        } else {
            AnySource source;
            const Placing placing = placing_of(of.mesh, options.frame, parts_[p].placement);
            slice_layers(source_of(of.mesh, placing, &frame, kept.source_tools(), source), target, call, own.info);
        }
    } catch (Refused& refused) {
        throw Refused{blamed_on_part(std::move(refused.error), p)};
    }
}

}  // namespace

void slice_parts(std::span<const Part> parts, const SliceCall& call, LayerTarget* target, SliceInfo& info) {
    PartSlicing(parts, call).slice(target, info);
}

}  // namespace lamella
