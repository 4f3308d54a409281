#include "lamella/sink.hpp"

#include <utility>

#include "base/guard.hpp"
#include "lamella/prepare.hpp"
#include "slicing/handover/hand_over.hpp"
#include "slicing/handover/sink_bands.hpp"
#include "slicing/part_slicer.hpp"
#include "slicing/prepared_parts.hpp"

namespace lamella {

namespace {

class SinkOutput final : public SliceOutput {
public:
    explicit SinkOutput(const LayerSink& sink) : sink_(sink) {}

    Status admit(const PlaneSet& /*planes*/, const Buckets& /*buckets*/, const SliceResult& /*result*/,
                 std::uint64_t /*memory_limit*/) override {
        return {};
    }

    std::uint64_t most_band_segments(int threads) const noexcept override {
        return sink_.order == SinkOrder::any ? BandPlan::no_limit : AscendingBands::most_segments(threads);
    }

    Status take_bands(const SweepInput& input, FunctionRef<void(BandTarget&)> sweep) override {
        if (sink_.order == SinkOrder::any) {
            take<AnyOrderBands>(input, sweep);
        } else {
            take<AscendingBands>(input, sweep);
        }
        return {};
    }

    Status finish(const SweepInput& input) override {
        SliceResult& result = input.result;
        set_counts(handed_over_.counts, result.region.keeps_contours() ? 0 : handed_over_.emptied, result.summary);
        return {};
    }

    SliceTotals totals(SliceResult& result) const {
        return {
            handed_over_.layers,  handed_over_.contours, handed_over_.points, handed_over_.closed_gaps,   result.unit_mm,
            result.close_gaps_mm, result.first_layer,    result.all_layers,   std::move(result.layer_of), result.summary};
    }

private:
    template <class Bands>
    void take(const SweepInput& input, FunctionRef<void(BandTarget&)> sweep) {
        Bands bands(sink_, input);
        sweep(bands);
        handed_over_ = bands.handed_over();
    }

    const LayerSink& sink_;
    HandedOver handed_over_;
};

}  // namespace

Result<SliceTotals> hand_over(const LayerSink& sink, const detail::SliceInput& input, const SliceOptions& options,
                              Workspace& workspace) noexcept {
    return guarded(options.control, [&]() -> Result<SliceTotals> {
        if (sink.take == nullptr) {
            return Error{ErrorCode::invalid_argument, "the sink has no function that takes layers"};
        }
        SinkOutput output(sink);
        SliceResult result(options.control.memory);
        if (Status status = detail::PartSlicer::slice_for(output, input, options, workspace, result); !status) {
            return status.error();
        }
        return output.totals(result);
    });
}

Result<SliceTotals> slice_to(const LayerSink& sink, const MeshView& mesh, const SliceOptions& options,
                             Workspace& workspace) noexcept {
    return hand_over(sink, {mesh}, options, workspace);
}

Result<SliceTotals> slice_to(const LayerSink& sink, const PreparedMesh& mesh, const SliceOptions& options,
                             Workspace& workspace) noexcept {
    return hand_over(sink, mesh.parts().input(), options, workspace);
}

Result<SliceTotals> slice_to(const LayerSink& sink, const MeshView& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return slice_to(sink, mesh, options, workspace);
}

Result<SliceTotals> slice_to(const LayerSink& sink, const PreparedMesh& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return slice_to(sink, mesh, options, workspace);
}

}  // namespace lamella
