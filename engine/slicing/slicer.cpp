// Where calls of slices enter: from any source, to any destination.
#include "slicing/slicer.hpp"

#include <unistd.h>
#include <algorithm>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/destination.hpp"
#include "lamella/slice.hpp"
#include "lamella/source.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/prepared_source.hpp"
#include "slicing/handover/sink_target.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

using detail::PreparedImpl;
using detail::SlicerImpl;
using detail::SourceImpl;

/// A prepared mesh has its grid and its frame already: the options may leave them out, or repeat them.
SliceOptions options_for(const PreparedImpl& prepared, const SliceOptions& options) {
    const Frame& asked = options.frame;
    if (asked.grid_mm != 0 && asked.grid_mm != prepared.asked_grid_mm && asked.grid_mm != prepared.asked.grid_mm) {
        throw Refused{{ErrorCode::invalid_argument, "the mesh was prepared on another grid than the one asked for"}};
    }
    if (!asked.transform.is_identity() && !(asked.transform == prepared.asked.transform)) {
        throw Refused{{ErrorCode::invalid_argument, "the mesh was prepared with another transform than the one asked for"}};
    }
    if (asked.as_mesh_numbers && !prepared.asked.as_mesh_numbers) {
        throw Refused{{ErrorCode::invalid_argument, "the mesh was prepared in double, not as its own numbers"}};
    }
    SliceOptions own = options;
    own.frame = prepared.asked;
    return own;
}

/// Calls use(source, call) for a mesh or a prepared one.
template <class Use>
void with_source(const Source& from, const SliceCall& call, Use use) {
    SourceTools tools = call.kept.source_tools();
    if (const PreparedImpl* const prepared = from.prepared()) {
        const SliceOptions options = options_for(*prepared, call.options);
        PreparedSource source(*prepared, tools);
        use(source, SliceCall{options, call.tuning, call.context, call.kept});
    } else {
        with_mesh_source(from.mesh(), placing_of(from.mesh(), call.options.frame), nullptr, tools,
                         [&](TriangleSource& source) { use(source, call); });
    }
}

/// What no mesh can be sliced with, and no other source than meshes gives.
void check(const Source& from, const SliceCall& call) {
    check_options(call.options, call.tuning);
    const bool is_section = call.options.content == LayerContent::section;
    if (from.other() != nullptr && (call.options.origins || !is_section)) {
        throw Refused{{ErrorCode::invalid_argument, "a file in pieces has neither origins nor faces; read it whole"}};
    }
    if (!is_section) {
        check_faces(from, call.options);
    }
}

template <class T>
void copy_to(Array<T>& to, const Vector<T>& from) {
    to.resize_discarding(from.size());
    std::copy(from.begin(), from.end(), to.data());
}

/// Layers come in ascending order, and count contours and points from their own first.
class Collecting {
public:
    Collecting(const Memory* memory, std::uint64_t limit) : memory_(memory), limit_(limit) {}

    void take(const LayerView& view) noexcept {
        try {
            if (failure_ == nullptr) {
                add(view);
            }
        } catch (...) {
            failure_ = std::current_exception();
        }
    }
    /// Throws where some layer did not fit.
    void move_to(SliceResult& result) const {
        if (failure_ != nullptr) {
            std::rethrow_exception(failure_);
        }
        copy_to(result.layers, layers_);
        copy_to(result.contours, contours_);
        copy_to(result.points, points_);
        copy_to(result.stitches, stitches_);
        result.origins.set_size(0);
    }

private:
    void add(const LayerView& view) {
        const std::uint64_t bytes = (layers_.size() + 1) * sizeof(Layer) +
                                    (contours_.size() + view.contours.size()) * sizeof(Contour) +
                                    (points_.size() + view.points.size()) * sizeof(Point);
        if (bytes > limit_) {
            throw Refused{{ErrorCode::result_too_large,
                           "the result exceeds the memory limit of " + std::to_string(limit_) + " bytes"}};
        }
        layers_.push_back(view);
        layers_.back().first_contour = contours_.size();
        for (const Contour& own : view.contours) {
            Contour& contour = contours_.emplace_back(own);
            contour.first_point += points_.size() - view.first_point;
            contour.parent +=
                own.parent < 0 ? 0 : static_cast<std::int64_t>(layers_.back().first_contour - view.first_contour);
        }
        points_.insert(points_.end(), view.points.begin(), view.points.end());
        stitches_.insert(stitches_.end(), view.stitches.begin(), view.stitches.end());
    }

    const Memory* memory_;
    std::uint64_t limit_;
    Vector<Layer> layers_{memory_};
    Vector<Contour> contours_{memory_};
    Vector<Point> points_{memory_};
    Vector<Stitch> stitches_{memory_};
    std::exception_ptr failure_;
};

/// All of `result`, from layers that the source hands over one by one.
void collect_layers(const SourceImpl& source, const SliceCall& call, SliceResult& result) {
    Collecting collecting(call.context.memory, call.memory_limit());
    auto take = [&](const LayerView& layer) noexcept { collecting.take(layer); };
    const LayerSink sink{.take = take};
    SinkTarget target(sink);
    source.slice(target, call, result.info);
    collecting.move_to(result);
}

/// The target that a destination stands for.
class AnyTarget {
public:
    explicit AnyTarget(const Destination& to) {
        if (to.sink() != nullptr) {
            target_ = &kinds_.emplace<SinkTarget>(*to.sink());
        } else if (to.arrays() != nullptr) {
            target_ = &kinds_.emplace<HostTarget>(*to.arrays());
        } else {
            target_ = &kinds_.emplace<ResultTarget>();
        }
    }
    LayerTarget& operator*() noexcept { return *target_; }
    bool is_result() const noexcept { return std::holds_alternative<ResultTarget>(kinds_); }
    /// Null where it is none.
    SinkTarget* sink() noexcept { return std::get_if<SinkTarget>(&kinds_); }

private:
    std::variant<std::monostate, ResultTarget, SinkTarget, HostTarget> kinds_;
    LayerTarget* target_;
};

/// Layers of a file in pieces come one by one: a result and arrays take them when all are there.
void slice_pieces(AnyTarget& target, const SourceImpl& source, const SliceCall& call, SliceResult& result) {
    if (target.sink() != nullptr) {
        source.slice(*target.sink(), call, result.info);
    } else if (target.is_result()) {
        collect_layers(source, call, result);
    } else {
        SliceResult whole(call.context.memory);
        collect_layers(source, call, whole);
        hand_over_whole(whole, call, *target, result);
    }
}

/// Every slice: `result` gets what is known of it, and the layers where it is what `target` stands for.
void slice_for(AnyTarget& target, const Source& from, const SliceCall& call, SliceResult& result) {
    check(from, call);
    if (from.other() != nullptr) {
        slice_pieces(target, *from.other(), call, result);
    } else if (from.is_parts()) {
        slice_parts({from.parts(), from.part_count()}, call, *target, result);
    } else if (call.options.content != LayerContent::section) {
        slice_faces(from.mesh(), call, *target, result);
    } else {
        with_source(from, call,
                    [&](TriangleSource& source, const SliceCall& own) { slice_layers(source, *target, own, result); });
    }
}

}  // namespace

Result<SliceInfo> slice_tuned(Slicer& slicer, const Destination& to, const Source& from, const SliceOptions& options,
                              const Tuning& tuning, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceInfo> {
        if (to.result() != nullptr && &options == &to.result()->info.options) {
            // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): the result is filled anew
            const SliceOptions own = options;
            return slice_tuned(slicer, to, from, own, tuning, context);
        }
        SliceResult none(context.memory);  // of sinks and arrays, which take the layers
        SliceResult& result = to.result() != nullptr ? *to.result() : none;
        move_to(context.memory, result);
        AnyTarget target(to);
        slice_for(target, from, {options, tuning, context, SlicerImpl::of(slicer, context)}, result);
        return to.result() != nullptr ? SliceInfo(result.info) : std::move(result.info);
    });
}

Result<SliceInfo> Slicer::slice_to(const Destination& to, const Source& from, const SliceOptions& options,
                                   const Context& context) noexcept {
    return slice_tuned(*this, to, from, options, {}, context);
}

Result<SliceResult> Slicer::slice(const Source& from, const SliceOptions& options, const Context& context) noexcept {
    SliceResult result(context.memory);
    if (Result<SliceInfo> info = slice_to(result, from, options, context); !info) {
        return std::move(info).error();
    }
    return result;
}

Result<SliceInfo> Slicer::outline(const Source& from, const SliceOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceInfo> {
        const Tuning tuning;
        Context quiet = context;
        quiet.progress = {};
        const SliceCall call{options, tuning, quiet, SlicerImpl::of(*this, context)};
        check(from, call);
        SliceInfo info;
        if (from.other() != nullptr) {
            from.other()->outline(call, info);
        } else if (from.is_parts()) {
            outline_parts({from.parts(), from.part_count()}, call, info);
        } else if (options.content != LayerContent::section) {
            outline_faces(from.mesh(), call, info);
        } else {
            with_source(from, call, [&](TriangleSource& source, const SliceCall& own) { count_layers(source, own, info); });
        }
        return info;
    });
}

Result<SliceResult> slice(const Source& from, const SliceOptions& options, const Context& context) noexcept {
    return Slicer().slice(from, options, context);
}

namespace detail {

std::uint64_t usual_memory_limit() {
    const auto pages = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PHYS_PAGES)));
    return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) / 2;
}

SlicerImpl::SlicerImpl(const Memory* host) : counted(host), usual_limit(usual_memory_limit()) {}

SlicerImpl& SlicerImpl::of(Slicer& slicer, const Context& context) {
    std::unique_ptr<SlicerImpl>& kept = slicer.impl_;
    if (kept == nullptr || kept->counted.host() != context.memory) {
        kept = std::make_unique<SlicerImpl>(context.memory);
    }
    if (kept->parallel == nullptr || !kept->parallel->serves(context)) {
        kept->parallel = std::make_unique<Parallel>(context);
    }
    kept->parallel->follow(context.stop);
    return *kept;
}

std::size_t SlicerImpl::bytes() const noexcept {
    const auto made = std::count_if(sweeps.begin(), sweeps.end(), [](const auto& sweep) { return sweep != nullptr; });
    return sizeof(*this) + static_cast<std::size_t>(made) * sizeof(BandSweep) + counted.bytes();
}

void SlicerImpl::trim() {
    const std::size_t most =
        buckets.segments.empty() ? 0 : *std::max_element(buckets.segments.begin(), buckets.segments.end());
    const bool all = sweeps_made_regions && !last_made_regions;
    for (auto& sweep : sweeps) {
        if (sweep != nullptr && (all || sweep->most_segments() > 2 * most)) {
            sweep.reset();
        }
    }
    sweeps_made_regions = last_made_regions;
    output.placement.trim();
    output.pool.outputs.clear();
    bands.trim();
    buckets.trim();
    planes.trim();
}

}  // namespace detail

Slicer::Slicer() noexcept = default;
Slicer::~Slicer() = default;
Slicer::Slicer(Slicer&&) noexcept = default;
Slicer& Slicer::operator=(Slicer&&) noexcept = default;

std::size_t Slicer::bytes() const noexcept {
    return impl_ == nullptr ? 0 : impl_->bytes();
}

void Slicer::trim() noexcept {
    try {
        if (impl_ != nullptr) {
            impl_->trim();
        }
    } catch (...) {
        reset();  // no memory is left even for less
    }
}

void Slicer::reset() noexcept {
    impl_.reset();
}

PreparedMesh::PreparedMesh(std::unique_ptr<const detail::PreparedImpl> impl) noexcept : impl_(std::move(impl)) {}
PreparedMesh::~PreparedMesh() = default;
PreparedMesh::PreparedMesh(PreparedMesh&&) noexcept = default;
PreparedMesh& PreparedMesh::operator=(PreparedMesh&&) noexcept = default;

std::size_t PreparedMesh::bytes() const noexcept {
    return impl_->bytes();
}

const Frame& PreparedMesh::frame() const noexcept {
    return impl_->asked;
}

Result<PreparedMesh> prepare(const MeshView& mesh, const Frame& frame, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<PreparedMesh> {
        const Parallel parallel(context);
        parallel.begin_stage(1, 5);
        auto made = std::make_unique<detail::PreparedImpl>(context.memory);
        made->frame = choose_frame(mesh, frame, true, {}, parallel);
        made->bounds = made->frame.bounds;
        made->asked = frame;
        made->asked_grid_mm = frame.grid_mm;
        made->asked.grid_mm = made->frame.unit.mm;
        made->build(mesh, parallel);
        if (made->triangles.empty()) {
            made->frame.bounds = {};  // the box of nothing chooses no planes
        }
        parallel.finish();
        return PreparedMesh(std::move(made));
    });
}

}  // namespace lamella
