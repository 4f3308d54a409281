#include "slicing/parts/unite_parts.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/clock.hpp"
#include "base/vector.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/result/band_output.hpp"
#include "slicing/result/stacked_outputs.hpp"

namespace lamella {

namespace {

constexpr std::size_t layers_a_task = 16;

class Uniting {
public:
    Uniting(const SliceResult& apart, const Control& control, const Parallel& parallel, SliceResult& united)
        : apart_(apart),
          control_(control),
          parallel_(parallel),
          united_(united),
          builders_(static_cast<std::size_t>(parallel.threads())) {}

    void build_all(FunctionRef<void(double)> reach) {
        const std::size_t layers = apart_.layers.size();
        outputs_.resize((layers + layers_a_task - 1) / layers_a_task);
        parallel_.run(outputs_.size(), [&](std::size_t task, int worker) {
            build(task, worker);
            reach(static_cast<double>(task) / static_cast<double>(outputs_.size()));
        });
    }

    void place_all() {
        united_.layers.resize_discarding(apart_.layers.size());
        std::copy(apart_.layers.begin(), apart_.layers.end(), united_.layers.begin());
        counts_ = stack_outputs(outputs_, !apart_.origins.empty(), parallel_, united_);
    }

    const ContourCounts& counts() const noexcept { return counts_; }

private:
    /// What a thread builds layers with.
    struct Builder {
        Builder(const Memory* memory, const StopCheck& stop) : worker(memory, stop), given(memory) {}
        Worker worker;
        LayerBuilder layers{worker};
        Vector<Path> given;
    };

    void build(std::size_t task, int number) {
        auto& builder = builders_[static_cast<std::size_t>(number)];
        if (builder == nullptr) {
            builder = std::make_unique<Builder>(control_.memory, parallel_.stop());
            builder->layers.rules = {
                .region = &united_.region, .unit_mm = apart_.unit_mm, .first_layer = apart_.first_layer};
        }
        auto output = std::make_unique<BandOutput>(control_.memory);
        output->with_origins = !apart_.origins.empty();
        output->begin_in_buffer(0);
        output->first_layer = task * layers_a_task;
        const std::size_t end = std::min<std::size_t>(apart_.layers.size(), output->first_layer + layers_a_task);
        for (std::size_t l = output->first_layer; l < end; ++l) {
            builder->given.clear();
            for (const Contour& contour : apart_.contours_of(apart_.layers[l])) {
                builder->given.push_back(as_given(contour));
            }
            builder->layers.build_given(builder->given, *output);
        }
        outputs_[task] = std::move(output);
    }

    /// As its facets run: a role that overruled them has turned it.
    Path as_given(const Contour& contour) const noexcept {
        const PointOrigin* const origins = apart_.origins.empty() ? nullptr : apart_.origins_of(contour).data();
        Path given = given_path(apart_.points_of(contour), origins, contour.role != Role::open);
        given.segments = contour.segments;
        given.item.reverse =
            (contour.flags & orientation_overruled) != 0 && (contour.orientation > 0) != (contour.role == Role::outer);
        given.item.flags = static_cast<std::uint16_t>(contour.flags & ~orientation_overruled);
        given.item.part = contour.part;
        return given;
    }

    const SliceResult& apart_;
    const Control& control_;
    const Parallel& parallel_;
    SliceResult& united_;
    std::vector<std::unique_ptr<Builder>> builders_;
    std::vector<std::unique_ptr<BandOutput>> outputs_;
    ContourCounts counts_;
};

}  // namespace

void unite_parts(const SliceResult& apart, const Control& control, const Parallel& parallel, FunctionRef<void(double)> reach,
                 SliceResult& united) {
    const auto start = Clock::now();
    Uniting uniting(apart, control, parallel, united);
    uniting.build_all(reach);
    uniting.place_all();
    united.closed_gaps.resize_discarding(apart.closed_gaps.size());
    std::copy(apart.closed_gaps.begin(), apart.closed_gaps.end(), united.closed_gaps.begin());
    united.layer_of.resize_discarding(apart.layer_of.size());
    std::copy(apart.layer_of.begin(), apart.layer_of.end(), united.layer_of.begin());
    united.first_layer = apart.first_layer;
    united.all_layers = apart.all_layers;
    united.part_count = apart.part_count;
    united.part_regions = PartRegions::united;
    united.close_gaps_mm = apart.close_gaps_mm;
    united.gap_sense = apart.gap_sense;
    united.unit_mm = apart.unit_mm;
    united.summary = apart.summary;
    set_counts(uniting.counts(), united);
    united.summary.ms.fill += milliseconds_since(start);
}

}  // namespace lamella
