#include "slicing/result/layer_target.hpp"

#include <atomic>
#include <cassert>
#include <cstring>
#include <string>
#include <tuple>
#include <utility>

#include "base/guard.hpp"
#include "base/sort.hpp"
#include "base/words.hpp"

namespace lamella {

namespace {

/// Makes `array` hold `count`, the first `kept` of which stay. Where `more` will follow, there is some room for them.
template <class T>
void extend(Array<T>& array, std::uint64_t kept, std::uint64_t count, const StopCheck& stop, bool more = false) {
    if (kept > 0 && count > array.capacity()) {
        Array<T> larger(array.memory());
        larger.resize_discarding(more ? count + kept / 2 : count);
        StopPace pace;
        pace.follow(stop);
        pace.in_stretches(0, kept, 1, [&](std::size_t begin, std::size_t end) {
            std::copy(array.data() + begin, array.data() + end, larger.data() + begin);
        });
        array = std::move(larger);
    }
    array.resize_discarding(count);
}

}  // namespace

void LayerTarget::begin_bands(const OutputPlan& plan, std::size_t lead, bool origins) {
    plan_ = &plan;
    lead_ = lead;
    with_origins_ = origins;
    head_ = 0;
    aborted_ = false;
    totals_ = {};
    plan.scratch.in_flight.assign(plan.bands.size(), {});
    in_flight_ = plan.scratch.in_flight;
    plan.scratch.idle.clear();
    for (const auto& output : plan.scratch.outputs) {
        plan.scratch.idle.push_back(output.get());
    }
}

BandOutput* LayerTarget::acquire(std::size_t band) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return aborted_ || band <= head_ + lead_; });
    if (aborted_) {
        return nullptr;
    }
    auto& [memory, outputs, idle, in_flight, placed] = plan_->scratch;
    if (idle.empty()) {
        outputs.push_back(std::make_unique<BandOutput>(memory));
        idle.push_back(outputs.back().get());
    }
    BandOutput* const output = in_flight_[band].output = idle.back();
    idle.pop_back();
    output->first_layer = plan_->bands[band].first;
    output->with_origins = with_origins_;
    output->reader = nullptr;
    output->band = band;
    make_room(band, *output, lock);
    return output;
}

void LayerTarget::put_idle(std::size_t band) {
    plan_->scratch.idle.push_back(std::exchange(in_flight_[band].output, nullptr));
}

void LayerTarget::abort() {
    {
        const std::lock_guard lock(mutex_);
        aborted_ = true;
    }
    changed_.notify_all();
}

/// Where nobody knows how many points there will be, most bands are kept, and none waits.
void PlacedTarget::begin_placing(const OutputPlan& plan, std::span<Point> points, std::span<PointOrigin> origins,
                                 bool origins_asked, bool keeps) {
    const std::size_t usual_lead = 2 * static_cast<std::size_t>(plan.parallel.threads());
    begin_bands(plan, plan.segments == 0 ? plan.bands.size() : usual_lead, origins_asked);
    points_ = points;
    origins_ = origins;
    keeps_ = keeps;
    outgrown_ = false;
    before_ = all_;
    placed_ = &plan.scratch.placed;
    const std::size_t count = plan.bands.size();
    placed_->erase(placed_->begin() + static_cast<std::ptrdiff_t>(std::min(count, placed_->size())), placed_->end());
    placed_->reserve(count);
    while (placed_->size() < count) {
        placed_->emplace_back(plan.scratch.memory);
    }
}

void PlacedTarget::make_room(std::size_t band, BandOutput& output, std::unique_lock<std::mutex>& lock) {
    swap_lists(band, output);  // those that the last call has left there are likely as long
    const PointStretch room = in_flight_[band].room = find_room(band);
    const std::uint64_t size = room.end - room.begin;
    if (size > 0) {
        output.begin(points_.subspan(room.begin, size), with_origins_ ? origins_.subspan(room.begin, size) : origins_);
        return;
    }
    lock.unlock();
    output.begin_in_buffer(plan_->bands[band].segments);
}

void PlacedTarget::swap_lists(std::size_t band, BandOutput& output) const noexcept {
    PlacedBand& placed = (*placed_)[band];
    placed.contours.swap(output.contours);
    placed.layer_contours.swap(output.layer_contours);
    placed.stitches.swap(output.stitches);
}

/// Where the band's points will lie if each unfinished band before it has a point for each segment. None if the points of
/// another band may come to lie there.
PointStretch PlacedTarget::find_room(std::size_t band) const noexcept {
    std::uint64_t begin = all_.points;
    std::uint64_t taken = 0;
    for (std::size_t b = head_; b < band; ++b) {
        begin += plan_->bands[b].segments;
        taken = std::max(taken, in_flight_[b].room.end);
    }
    const std::uint64_t end = begin + plan_->bands[band].segments;
    const bool is_free = !outgrown_ && taken <= begin && end <= points_.size();
    return is_free ? PointStretch{begin, end} : PointStretch{};
}

void PlacedTarget::submit(std::size_t band) {
    std::unique_lock lock(mutex_);
    in_flight_[band].done = true;
    const BandOutput& own = *in_flight_[band].output;
    outgrown_ = outgrown_ || own.point_count > plan_->bands[band].segments;
    if (own.in_buffer()) {
        in_flight_[band].room = {};
    }
    // Places are fixed under the lock and buffers copied outside it; meanwhile another thread may place the next head.
    const std::size_t begin = head_;
    while (head_ < in_flight_.size() && in_flight_[head_].done &&
           clear_rooms(all_.points + in_flight_[head_].output->point_count)) {
        place_head();
    }
    const std::size_t end = head_;
    if (begin == end) {
        return;
    }
    lock.unlock();
    changed_.notify_all();
    for (std::size_t b = begin; b < end; ++b) {
        if (copy_points(b) || !keeps_) {
            const std::lock_guard again(mutex_);
            put_idle(b);
        }
    }
}

/// Where the head has outgrown its room and will reach to `end`: moves later bands that lie in its way to buffers. False if
/// one of them is still being swept: its thread will try again.
bool PlacedTarget::clear_rooms(std::uint64_t end) {
    const std::size_t begun_end = std::min(head_ + lead_ + 1, in_flight_.size());
    for (std::size_t b = head_ + 1; b < begun_end; ++b) {
        BandInFlight& later = in_flight_[b];
        if (later.room.begin < end && later.room.end > 0) {
            assert(outgrown_);
            if (!later.done) {
                return false;
            }
            later.output->move_to_buffer(0);
            later.room = {};
        }
    }
    return true;
}

void PlacedTarget::place_head() {
    PlacedBand& placed = (*placed_)[head_];
    BandInFlight& head = in_flight_[head_];
    BandOutput& output = *head.output;
    placed.first_point = all_.points;
    placed.first_contour = all_.contours;
    swap_lists(head_, output);
    if (head.room.end > 0 && head.room.begin != all_.points) {
        assert(head.room.begin > all_.points);
        const std::size_t count = output.point_count;
        std::memmove(points_.data() + all_.points, output.points, count * sizeof(Point));
        if (output.with_origins) {
            std::memmove(origins_.data() + all_.points, output.origins, count * sizeof(PointOrigin));
        }
    }
    head.room = {};
    output.totals.points = output.point_count;
    output.totals.stitches = placed.stitches.size();
    totals_.add(output.totals);
    all_.add(output.totals);
    ++head_;
}

void PlacedTarget::write(std::uint64_t first, std::span<const Point> points) const noexcept {
    std::copy(points.begin(), points.end(), points_.data() + first);
}

/// From a buffer to the band's place. False if they do not fit there.
bool PlacedTarget::copy_points(std::size_t band) const {
    const std::uint64_t first = (*placed_)[band].first_point;
    const BandOutput& output = *in_flight_[band].output;
    const bool fits = first + output.point_count <= capacity();
    if (fits && output.in_buffer()) {
        StopPace pace;
        pace.follow(plan_->parallel.stop());
        pace.in_stretches(0, output.point_count, 1, [&](std::size_t begin, std::size_t end) {
            write(first + begin, {output.points + begin, output.points + end});
            if (output.with_origins) {
                std::copy(output.origins + begin, output.origins + end, origins_.data() + first + begin);
            }
        });
    }
    return fits;
}

std::uint64_t PlacedTarget::points_in_place() const noexcept {
    const auto kept =
        std::find_if(in_flight_.begin(), in_flight_.end(), [](const BandInFlight& b) { return b.output != nullptr; });
    return kept == in_flight_.end() ? all_.points
                                    : (*placed_)[static_cast<std::size_t>(kept - in_flight_.begin())].first_point;
}

void PlacedTarget::write_layers(std::span<Layer> layers, std::span<Contour> contours, std::span<Stitch> stitches) {
    const Parallel& parallel = plan_->parallel;
    assert(head_ == plan_->bands.size());
    layers = layers.subspan(plan_->first_index, plan_->layers);
    std::atomic<std::uint64_t> emptied_layers = 0;
    parallel.run(in_flight_.size(), [&](std::size_t band, int) {
        if (BandOutput* const kept = in_flight_[band].output; kept != nullptr) {
            copy_points(band);
            kept->release();
        }
        emptied_layers.fetch_add(write_band(band, layers, contours).emptied_layers, std::memory_order_relaxed);
    });
    totals_.emptied_layers += emptied_layers;
    write_stitches(stitches.empty() ? stitches : stitches.subspan(before_.stitches));
    totals_.describe(plan_->info);
}

/// Returns what is known of its layers only now.
LayerTotals PlacedTarget::write_band(std::size_t band, std::span<Layer> layers, std::span<Contour> contours) const {
    constexpr std::size_t contours_between_stops = std::size_t{1} << 14;
    const PlacedBand& placed = (*placed_)[band];
    Contour* out = contours.data() + placed.first_contour;
    for (std::size_t c = 0; c < placed.contours.size(); ++c, ++out) {
        *out = placed.contours[c];
        out->first_point += placed.first_point;
        out->parent += out->parent < 0 ? 0 : static_cast<std::int64_t>(placed.first_contour);
        if (c % contours_between_stops == contours_between_stops - 1) {
            plan_->parallel.stop_if_asked();
        }
    }
    LayerTotals totals;
    std::uint64_t first = placed.first_contour;
    PlaneIndex plane = plan_->bands[band].first;
    for (const std::uint32_t count : placed.layer_contours) {
        Layer& layer = layers[plane] = plan_->layer_at(plane);
        layer.first_contour = first;
        layer.contour_count = count;
        totals.add(layer);
        first += count;
        ++plane;
    }
    assert(plane == plan_->bands[band].last);
    return totals;
}

void PlacedTarget::write_stitches(std::span<Stitch> stitches) const {
    StopPace pace;
    pace.follow(plan_->parallel.stop());
    Stitch* out = stitches.data();
    for (std::size_t b = 0; b < in_flight_.size() && !stitches.empty(); ++b) {
        Stitch* const first = out;
        for (const Stitch& own : (*placed_)[b].stitches) {
            *out++ = {plan_->first_index + plan_->bands[b].first + own.layer, own.from, own.to};
        }
        sort_briefly(first, out, [&pace](const Stitch& a, const Stitch& b) {
            pace.spend(1);
            return std::tie(a.layer, a.from, a.to) < std::tie(b.layer, b.from, b.to);
        });
    }
}

void ResultTarget::admit(const OutputPlan& plan, std::uint64_t memory_limit) {
    const std::uint64_t point_bytes = sizeof(Point) + (plan.origins ? sizeof(PointOrigin) : 0);
    const std::uint64_t layers = plan.first_index + plan.layers;
    const std::uint64_t segments = all_.points + plan.segments;
    const std::uint64_t bytes = segments * point_bytes + layers * sizeof(Layer) +
                                plan.info.layer_of.size() * sizeof(std::uint64_t) +
                                (all_.contours + plan.cutting) * sizeof(Contour);
    if (bytes > memory_limit) {
        throw Refused{{ErrorCode::result_too_large,
                       counted(layers, "layer") + " with " + counted(segments, "segment") + " need " +
                           std::to_string(bytes) + " bytes, more than the memory limit of " + std::to_string(memory_limit)}};
    }
}

/// A closed contour has at most as many points as segments; an open one has one more, for which there is some room. What
/// very many open polylines have beyond that is kept until the array is made larger.
void ResultTarget::begin(const OutputPlan& plan) {
    const std::uint64_t before = all_.points;
    const std::uint64_t room = before + plan.segments + plan.segments / 64 + 64;
    const StopCheck& stop = plan.parallel.stop();
    extend(result_.points, before, room, stop, true);
    extend(result_.origins, plan.origins ? before : 0, plan.origins ? room : 0, stop, true);
    begin_placing(plan, result_.points.span(), result_.origins.span(), plan.origins, true);
}

void ResultTarget::finish() {
    const StopCheck& stop = plan_->parallel.stop();
    const std::uint64_t in_place = points_in_place();
    extend(result_.points, in_place, all_.points, stop);
    extend(result_.origins, with_origins_ ? in_place : 0, with_origins_ ? all_.points : 0, stop);
    points_ = result_.points.span();
    origins_ = result_.origins.span();
    extend(result_.layers, plan_->first_index, plan_->first_index + plan_->layers, stop, true);
    extend(result_.contours, before_.contours, all_.contours, stop, true);
    extend(result_.stitches, before_.stitches, all_.stitches, stop, true);
    write_layers(result_.layers.span(), result_.contours.span(), result_.stitches.span());
}

void describe_plan(const PlaneSet& planes, bool list_heights, SliceInfo& info) {
    const Vector<PlaneIndex>& listed = planes.plane_of_listed();
    info.layer_of.assign(listed.begin(), listed.end());
    if (list_heights) {
        info.options.heights_mm.emplace(planes.listed_mm().begin(), planes.listed_mm().end());
    }
    if (std::optional<std::vector<double>>& heights = info.options.heights_mm; !heights && !info.options.slabs.empty()) {
        heights.emplace();
        std::transform(info.options.slabs.begin(), info.options.slabs.end(), std::back_inserter(*heights), middle_of);
    }
    info.layers = planes.size();
    info.first_layer = planes.first_kept();
    info.planned_layers = planes.planned();
}

void add_work(const SliceInfo& part, std::uint64_t times, SliceInfo& sum) noexcept {
    sum.triangles += times * part.triangles;
    sum.degenerate += times * part.degenerate;
    sum.crossed += times * part.crossed;
    sum.segments += times * part.segments;
    sum.bands += part.bands;
    sum.ms.bucket += part.ms.bucket;
    sum.ms.sweep += part.ms.sweep;
    sum.ms.contours += part.ms.contours;
    sum.ms.nesting += part.ms.nesting;
    sum.ms.fill += part.ms.fill;
}

}  // namespace lamella
