#include "slicing/handover/sink_target.hpp"

#include <algorithm>
#include <tuple>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/sort.hpp"

namespace lamella {

namespace {

constexpr std::size_t window_bytes = std::size_t{1} << 26;
constexpr std::size_t few_points = std::size_t{1} << 14;

std::size_t share_of_band(int threads) noexcept {
    return window_bytes / (static_cast<std::size_t>(threads) + 1);
}

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
        view.points = detail::span_of(output.points + first_point, points);
        if (output.with_origins) {
            view.origins = detail::span_of(output.origins + first_point, points);
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
        sort_briefly(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Stitch& a, const Stitch& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
        return rest.first(count);
    }
};

}  // namespace

SinkTarget::SinkTarget(const LayerSink& sink) : sink_(sink), ascending_(sink.order == SinkOrder::ascending) {
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

std::uint64_t SinkTarget::most_band_segments(int threads) const noexcept {
    return !ascending_ || threads == 1 ? BandPlan::no_limit : share_of_band(threads) / sizeof(Point);
}

void SinkTarget::begin(const OutputPlan& plan) {
    announce(plan.info);
    plan.parallel.ask_host();
    const int threads = plan.parallel.threads();
    share_ = share_of_band(threads);
    begin_bands(plan, ascending_ ? static_cast<std::size_t>(threads) : plan.bands.size(), plan.origins);
}

/// All of a wide plane's band, which is one layer; of others what the band may keep, or as the head a few layers.
void SinkTarget::make_room(std::size_t band, BandOutput& output, std::unique_lock<std::mutex>& lock) {
    const std::size_t point_bytes = sizeof(Point) + (with_origins_ ? sizeof(PointOrigin) : 0);
    const std::uint64_t room = is_head(band) ? few_points : share_ / point_bytes;
    lock.unlock();
    const Band& own = plan_->bands[band];
    output.reader = this;
    output.begin_in_buffer(own.wide ? own.segments : std::min(own.segments, room));
}

void SinkTarget::layer_done(BandOutput& output) {
    if (!is_head(output.band)) {
        if (output.bytes_used() < share_) {
            return;
        }
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return aborted_ || is_head(output.band); });
        if (aborted_) {
            throw BandDropped();
        }
    }
    hand_over(output);
}

/// Hands over all layers of `output`, whose band is the head, and empties it. Throws Stopped where the host wants the call
/// to end.
void SinkTarget::hand_over(BandOutput& output) {
    LayerCursor cursor{output};
    while (cursor.layer < output.layer_contours.size()) {
        const auto plane = static_cast<PlaneIndex>(output.first_layer + cursor.layer);
        LayerView view = cursor.next(plan_->first_index + plane);
        static_cast<Layer&>(view) = plan_->layer_at(plane);
        view.contour_count = view.contours.size();
        view.grid_mm = plan_->info.grid_mm;
        sink_.take(view);
        output.totals.stitches += view.stitches.size();
        output.totals.add(static_cast<const Layer&>(view));
        plan_->parallel.ask_host();  // so that a sink which ends the call gets no layer more
    }
    output.drop_layers();
}

/// Where the band is the head, hands over what is left of it and of all done bands that follow. While it does so no other
/// thread can: the next head is either done, or its own thread will find that it is the head.
void SinkTarget::submit(std::size_t band) {
    std::unique_lock lock(mutex_);
    in_flight_[band].done = true;
    if (!is_head(band)) {
        return;
    }
    bool is_done = true;
    for (std::size_t head = band; is_done; ++head) {
        lock.unlock();
        BandOutput& output = *in_flight_[head].output;
        hand_over(output);
        lock.lock();
        totals_.add(output.totals);
        if (output.bytes_held() > share_) {
            output.release();
        }
        put_idle(head);
        head_.store(head + 1, std::memory_order_release);
        is_done = ascending_ && head + 1 < in_flight_.size() && in_flight_[head + 1].done;
        changed_.notify_all();
    }
}

}  // namespace lamella
