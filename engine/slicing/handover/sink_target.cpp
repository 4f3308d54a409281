#include "slicing/handover/sink_target.hpp"

#include <algorithm>
#include <span>
#include <tuple>
#include <utility>

#include "base/guard.hpp"
#include "base/parallel.hpp"

namespace lamella {

namespace {

constexpr std::size_t window_bytes = std::size_t{1} << 26;
constexpr std::size_t parcel_bytes = std::size_t{1} << 20;
constexpr std::size_t parcel_points = parcel_bytes / sizeof(Point);

/// Outputs that are not in use keep at most so much memory.
constexpr std::size_t most_idle_bytes = window_bytes / 2;

/// Takes the layers of an output one by one: contours, points and gaps then count from the layer's own first.
struct LayerCursor {
    BandOutput& output;
    std::size_t layer = 0;
    std::size_t first_contour = 0;
    std::uint64_t first_point = 0;
    std::size_t first_gap = 0;

    LayerView next(std::uint64_t index) {
        LayerView view;
        view.index = index;
        const std::span<Contour> contours =
            std::span<Contour>(output.contours).subspan(first_contour, output.layer_contours[layer]);
        std::uint64_t points = 0;
        for (Contour& contour : contours) {
            contour.first_point -= first_point;
            contour.parent -= contour.parent < 0 ? 0 : static_cast<std::int64_t>(first_contour);
            points += contour.point_count;
        }
        view.contours = contours;
        view.points = {output.points + first_point, points};
        if (output.with_origins) {
            view.origins = {output.origins + first_point, points};
        }
        view.stitches = take_gaps(index);
        first_contour += contours.size();
        first_point += points;
        ++layer;
        return view;
    }

    std::span<const Stitch> take_gaps(std::uint64_t index) {
        const std::span<Stitch> rest = std::span<Stitch>(output.stitches).subspan(first_gap);
        std::size_t count = 0;
        while (count < rest.size() && rest[count].layer == layer) {
            rest[count++].layer = index;
        }
        first_gap += count;
        std::sort(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(count),
                  [](const Stitch& a, const Stitch& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
        return rest.first(count);
    }
};

}  // namespace

SinkBands::SinkBands(const LayerSink& sink, const OutputPlan& plan)
    : sink_(sink), plan_(plan), ascending_(sink.order == SinkOrder::ascending), bands_(plan.bands.size()) {
    for (const auto& output : plan.scratch.outputs) {
        put_idle(output.get());
    }
}

std::uint64_t SinkBands::most_segments(int threads) noexcept {
    return threads == 1 ? BandPlan::no_limit : 4 * window_bytes / sizeof(Point) / static_cast<std::uint64_t>(threads);
}

BandOutput* SinkBands::acquire(std::size_t band) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return aborted_ || !ascending_ || band <= head_ + plan_.lead; });
    if (aborted_) {
        return nullptr;
    }
    BandOutput* const output = take_idle();
    output->first_layer = plan_.bands[band].first;
    output->reader = this;
    output->band = band;
    output->with_origins = plan_.origins;
    bands_[band].output = output;
    // All layers of a wide plane's band, which is one; of others a parcel, or the largest layer as it comes.
    const std::uint64_t segments = plan_.bands[band].segments;
    output->begin_in_buffer(plan_.bands[band].wide ? segments : std::min<std::uint64_t>(segments, parcel_points));
    return output;
}

BandOutput* SinkBands::take_idle() {
    auto& outputs = plan_.scratch.outputs;
    if (idle_.empty()) {
        outputs.push_back(std::make_unique<BandOutput>(plan_.scratch.memory));
        return outputs.back().get();
    }
    BandOutput* const output = idle_.back();
    idle_.pop_back();
    idle_bytes_ -= output->bytes_held();
    return output;
}

void SinkBands::put_idle(BandOutput* output) {
    output->drop_layers();
    output->reader = nullptr;
    if (idle_bytes_ + output->bytes_held() > most_idle_bytes) {
        output->release();
    }
    idle_bytes_ += output->bytes_held();
    idle_.push_back(output);
}

void SinkBands::give_back(std::size_t band) {
    const std::lock_guard lock(mutex_);
    put_idle(std::exchange(bands_[band].output, nullptr));
}

void SinkBands::abort() {
    {
        const std::lock_guard lock(mutex_);
        aborted_ = true;
    }
    changed_.notify_all();
}

void SinkBands::end_band(std::size_t band) {
    OwnBand& own = bands_[band];
    own.totals.counts = own.output->counts;
    totals_.add(own.totals);
    put_idle(std::exchange(own.output, nullptr));
}

void SinkBands::layer_done(BandOutput& output) {
    if (is_head(output.band)) {
        hand_over(bands_[output.band]);
    } else if (output.bytes_used() >= parcel_bytes) {
        put_aside(output);
    }
}

/// Waits until there is memory, or the band is the head.
void SinkBands::put_aside(BandOutput& output) {
    std::unique_lock lock(mutex_);
    const std::size_t bytes = output.bytes_held();
    changed_.wait(
        lock, [&] { return aborted_ || head_ == output.band || bytes_aside_ == 0 || bytes_aside_ + bytes <= window_bytes; });
    if (aborted_) {
        throw BandDropped();
    }
    if (head_ == output.band) {
        lock.unlock();
        hand_over(bands_[output.band]);
        return;
    }
    std::vector<BandOutput*>& parcels = bands_[output.band].parcels;
    parcels.reserve(parcels.size() + 1);
    parcels.push_back(take_idle());
    output.move_layers_to(*parcels.back());
    bytes_aside_ += bytes;
    lock.unlock();
    output.move_to_buffer(parcel_points);
}

/// First the parcels that were put aside, then the output. The band is the head.
void SinkBands::hand_over(OwnBand& band) {
    for (BandOutput* const parcel : band.parcels) {
        const std::size_t bytes = parcel->bytes_held();
        hand_over(*parcel, band.totals);
        {
            const std::lock_guard lock(mutex_);
            bytes_aside_ -= bytes;
            put_idle(parcel);
        }
        changed_.notify_all();
    }
    band.parcels.clear();
    hand_over(*band.output, band.totals);
}

/// Hands over all layers of `output` and empties it. Throws Stopped where the host wants the call to end.
void SinkBands::hand_over(BandOutput& output, LayerTotals& totals) const {
    LayerCursor cursor{output};
    while (cursor.layer < output.layer_contours.size()) {
        const auto plane = static_cast<PlaneIndex>(output.first_layer + cursor.layer);
        LayerView view = cursor.next(plan_.first_index + plane);
        static_cast<Layer&>(view) = plan_.layer_at(plane);
        view.contour_count = view.contours.size();
        view.grid_mm = plan_.result.info.grid_mm;
        sink_.take(view);
        totals.stitches += view.stitches.size();
        totals.emptied += view.segments > 0 && view.contours.empty() ? 1 : 0;
        plan_.parallel.ask_host();  // so that a sink which ends the call gets no layer more
    }
    totals.contours += output.contours.size();
    totals.points += output.point_count;
    output.drop_layers();
}

/// Where the band is the head, hands over what is left of it and of all done bands that follow. While it does so no other
/// thread can: the next head is either done, or its own thread will find that it is the head.
void SinkBands::submit(std::size_t band) {
    BandOutput& output = *bands_[band].output;
    if (!is_head(band) && output.bytes_used() > parcel_bytes / 16) {
        put_aside(output);
    }
    std::unique_lock lock(mutex_);
    bands_[band].done = true;
    if (!is_head(band)) {
        return;
    }
    bool is_done = true;
    for (std::size_t head = band; is_done; ++head) {
        lock.unlock();
        hand_over(bands_[head]);
        lock.lock();
        end_band(head);
        head_.store(head + 1, std::memory_order_release);
        is_done = ascending_ && head + 1 < bands_.size() && bands_[head + 1].done;
        changed_.notify_all();
    }
}

SinkTarget::SinkTarget(const LayerSink& sink) : sink_(sink) {
    if (!sink.take) {
        throw Refused{{ErrorCode::invalid_argument, "the sink has no function that takes layers"}};
    }
}

void SinkTarget::announce(const SliceInfo& info) {
    if (sink_.begin && !is_announced_) {
        sink_.begin(info);
    }
    is_announced_ = true;
}

void SinkTarget::finish(const OutputPlan& plan) {
    bands_->totals().describe(plan.result.info);
}

}  // namespace lamella
