// Where calls of slices enter: from any source, to any destination.
#include "slicing/slicer.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/guard.hpp"
#include "base/system/machine.hpp"
#include "lamella/destination.hpp"
#include "lamella/source.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/prepared_source.hpp"
#include "slicing/handover/sink_target.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

using detail::PreparedImpl;
using detail::SlicerImpl;

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

/// Any source to any destination. Where that is null, `info` gets what is known before anything is cut.
void slice_source(const Source& from, const Destination* to, const SliceCall& call, SliceInfo& info) {
    AnyTarget any;
    LayerTarget* const target = target_of(to, call.context.memory, any);
    check(from, call);
    if (from.other() != nullptr) {
        from.other()->slice(target, call, info);
    } else if (from.is_parts()) {
        slice_parts({from.parts(), from.part_count()}, call, target, info);
    } else if (call.options.content != LayerContent::section) {
        slice_faces(from.mesh(), call, target, info);
    } else if (const PreparedImpl* const prepared = from.prepared(); prepared != nullptr) {
        SliceOptions options = call.options;
        options.frame = prepared->frame_for(call.options.frame);
        PreparedSource source(*prepared, call.kept.source_tools());
        slice_layers(source, target, {options, call.tuning, call.context, call.kept}, info);
    } else {
        const Placing placing = placing_of(from.mesh(), call.options.frame);
        AnySource source;
        slice_layers(source_of(from.mesh(), placing, nullptr, call.kept.source_tools(), source), target, call, info);
    }
}

}  // namespace

Result<SliceInfo> slice_tuned(Slicer& slicer, const Destination& to, const Source& from, const SliceOptions& options,
                              const Tuning& tuning, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceInfo> {
        SliceInfo of_others;  // sinks and arrays take the layers alone
        SliceInfo& info = to.result() != nullptr ? to.result()->info : of_others;
        std::optional<SliceOptions> own;  // the result is filled anew, and its options may be those that are asked for
        if (&options == &info.options) {
            own = options;
        }
        slice_source(from, &to, {own ? *own : options, tuning, context, SlicerImpl::of(slicer, context, tuning)}, info);
        return to.result() != nullptr ? SliceInfo(info) : std::move(info);
    });
}

Result<SliceInfo> Slicer::slice_to(const Destination& to, const Source& from, const SliceOptions& options,
                                   const Context& context) noexcept {
    return slice_tuned(*this, to, from, options, {}, context);
}

Result<SliceResult> Slicer::slice(const Source& from, const SliceOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceResult> {
        SliceResult result(context.memory);
        const Destination to(result);
        slice_source(from, &to, {options, {}, context, SlicerImpl::of(*this, context, {})}, result.info);
        return result;
    });
}

Result<SliceInfo> Slicer::outline(const Source& from, const SliceOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceInfo> {
        Context quiet = context;
        quiet.progress = {};
        SliceInfo info;
        slice_source(from, nullptr, {options, {}, quiet, SlicerImpl::of(*this, context, {})}, info);
        return info;
    });
}

Status Slicer::make_ready(std::uint64_t triangles, const Context& context) noexcept {
    return guarded(context, [&]() -> Status {
        constexpr std::uint64_t few = 1 << 20;  // more are likely cut in tiers
        constexpr std::size_t small_blocks = 64;
        SlicerImpl& kept = SlicerImpl::of(*this, context, {});
        const auto touch = [&](std::span<std::byte> memory) {
            constexpr std::size_t page = 4096;
            kept.parallel->run_ranges(memory.size() / page, 64, [memory](std::size_t begin, std::size_t end, int) {
                for (std::size_t i = begin; i < end; ++i) {
                    memory[i * page] = {};
                }
            });
        };
        kept.buckets.records.resize_discarding(triangles <= few ? triangles : std::max(few, triangles / 3));
        touch(std::as_writable_bytes(kept.buckets.records.span()));
        touch(kept.scratch.make_ahead(small_blocks * kept.buckets.records.size()));
        return {};
    });
}

Result<SliceResult> slice(const Source& from, const SliceOptions& options, const Context& context) noexcept {
    return Slicer().slice(from, options, context);
}

namespace detail {

std::uint64_t memory_limit(std::uint64_t asked) {
    return asked != 0 ? asked : physical_memory_bytes() / 2;
}

SlicerImpl::SlicerImpl(const Memory* host, InstructionSet level)
    : scratch(host), instructions(level), usual_limit(memory_limit()) {}

SlicerImpl& SlicerImpl::of(Slicer& slicer, const Context& context, const Tuning& tuning) {
    const InstructionSet level = tuning.instructions ? *tuning.instructions : instruction_set();
    std::unique_ptr<SlicerImpl>& kept = slicer.impl_;
    if (kept == nullptr || kept->scratch.host() != context.memory || kept->instructions != level) {
        kept = std::make_unique<SlicerImpl>(context.memory, level);
    }
    if (kept->parallel == nullptr || !kept->parallel->serves(context)) {
        kept->parallel = std::make_unique<Parallel>(context);
    }
    kept->parallel->follow(context.stop);
    return *kept;
}

SlicerImpl& SlicerImpl::side_of(int worker) {
    std::unique_ptr<SlicerImpl>& side = sides[static_cast<std::size_t>(worker)];
    if (side == nullptr) {
        side = std::make_unique<SlicerImpl>(memory, instructions);
        side->usual_limit = usual_limit;
        side->parallel = std::make_unique<Parallel>(Context{.threads = 1, .memory = memory});
    }
    side->parallel->follow(parallel->stop());
    return *side;
}

std::size_t SlicerImpl::bytes() const noexcept {
    const auto made = std::count_if(sweeps.begin(), sweeps.end(), [](const auto& sweep) { return sweep != nullptr; });
    return sizeof(*this) + static_cast<std::size_t>(made) * sizeof(BandSweep) + scratch.bytes();
}

bool SlicerImpl::holds_too_much() const noexcept {
    const std::size_t most =
        buckets.segments.empty() ? 0 : *std::max_element(buckets.segments.begin(), buckets.segments.end());
    const auto is_large = [most](const auto& sweep) { return sweep != nullptr && sweep->most_segments() > 2 * most; };
    return (sweeps_made_regions && !last_made_regions) || std::any_of(sweeps.begin(), sweeps.end(), is_large) ||
           buckets.records.capacity() > 2 * bands.most_records() ||
           any_has_slack(buckets.lowest_corners, buckets.list_begin, buckets.crossed, buckets.counters,
                         buckets.blocks.blocks, buckets.vertices, bands.reaching, bands.seeds.items);
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
    if (impl_ != nullptr && impl_->holds_too_much()) {
        reset();
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
        auto made = std::make_unique<detail::PreparedImpl>(mesh, context.memory);
        made->frame = choose_frame(mesh, frame, true, {}, parallel);
        made->bounds = made->frame.bounds;
        made->asked = frame;
        made->asked_grid_mm = frame.grid_mm;
        made->asked.grid_mm = made->frame.unit.mm;
        made->build(parallel);
        if (made->order.empty()) {
            made->frame.bounds = {};  // the box of nothing chooses no planes
        }
        parallel.finish();
        return PreparedMesh(std::move(made));
    });
}

}  // namespace lamella
