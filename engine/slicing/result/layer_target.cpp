#include "slicing/result/layer_target.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <string>
#include <tuple>
#include <utility>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/words.hpp"

namespace lamella {

namespace {

/// Makes `array` hold `count`, the first `kept` of which stay.
template <class T>
void extend(Array<T>& array, std::size_t kept, std::size_t count, const StopCheck& stop) {
    if (count > array.capacity()) {
        Array<T> larger(array.memory());
        larger.resize_discarding(count);
        StopPace pace;
        pace.follow(stop);
        pace.in_stretches(0, kept, 1, [&](std::size_t begin, std::size_t end) {
            std::copy(array.data() + begin, array.data() + end, larger.data() + begin);
        });
        array = std::move(larger);
    }
    array.set_size(count);
}

}  // namespace

void BandQueue::begin(std::span<const Band> bands, std::size_t lead, bool origins) {
    bands_ = bands;
    lead_ = lead;
    with_origins_ = origins;
    head_ = 0;
    aborted_ = false;
    in_flight_.assign(bands.size(), {});
    idle_.clear();
    for (const auto& output : pool_.outputs) {
        idle_.push_back(output.get());
    }
}

BandOutput* BandQueue::acquire(std::size_t band) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return aborted_ || band <= head_ + lead_; });
    if (aborted_) {
        return nullptr;
    }
    if (idle_.empty()) {
        pool_.outputs.push_back(std::make_unique<BandOutput>(pool_.memory));
        idle_.push_back(pool_.outputs.back().get());
    }
    BandOutput* const output = in_flight_[band].output = idle_.back();
    idle_.pop_back();
    output->first_layer = bands_[band].first;
    output->with_origins = with_origins_;
    output->reader = nullptr;
    output->band = band;
    make_room(band, *output, lock);
    return output;
}

void BandQueue::give_back(std::size_t band) {
    const std::lock_guard lock(mutex_);
    put_idle(band);
}

void BandQueue::put_idle(std::size_t band) {
    idle_.push_back(std::exchange(in_flight_[band].output, nullptr));
}

void BandQueue::abort() {
    {
        const std::lock_guard lock(mutex_);
        aborted_ = true;
    }
    changed_.notify_all();
}

void Placement::begin(std::span<const Band> bands, std::size_t lead, const PointRoom& room, const StopCheck& stop) {
    BandQueue::begin(bands, lead, !room.origins.empty());
    stop_ = stop;
    room_ = room;
    keeps_ = false;
    outgrown_ = false;
    totals_ = {};
    placed_.erase(placed_.begin() + static_cast<std::ptrdiff_t>(std::min(bands.size(), placed_.size())), placed_.end());
    for (Placed& placed : placed_) {
        placed.clear();
    }
    placed_.reserve(bands.size());
    while (placed_.size() < bands.size()) {
        placed_.emplace_back(pool_.memory);
    }
}

void Placement::begin(std::span<const Band> bands, std::size_t lead, bool origins, SliceResult& result,
                      const StopCheck& stop) {
    result.origins.resize_discarding(origins ? result.points.size() : 0);
    begin(bands, lead, {.points = result.points.span(), .origins = result.origins.span()}, stop);
    with_origins_ = origins;
    keeps_ = true;
}

void Placement::make_room(std::size_t band, BandOutput& output, std::unique_lock<std::mutex>& lock) {
    std::optional<Stretch>& room = placed_[band].room;
    room.reset();  // where the band has been begun before
    if (room = find_room(band); room) {
        const std::size_t size = room->end - room->begin;
        output.begin(room_.points.subspan(room->begin, size),
                     with_origins_ ? room_.origins.subspan(room->begin, size) : room_.origins);
        return;
    }
    lock.unlock();
    output.begin_in_buffer(bands_[band].segments);
}

/// Where the band's points will lie if each unfinished band before it has a point for each segment. None if the points of
/// another band may come to lie there.
std::optional<Placement::Stretch> Placement::find_room(std::size_t band) {
    if (room_.writer != nullptr || outgrown_) {
        return {};
    }
    Stretch room{totals_.points, 0};
    for (std::size_t b = head_; b < band; ++b) {
        room.begin += bands_[b].segments;
    }
    room.end = room.begin + bands_[band].segments;
    if (room.begin > room.end || room.end > room_.points.size()) {
        return {};
    }
    for (std::size_t b = head_; b < begun_end(); ++b) {
        const std::optional<Stretch>& other = placed_[b].room;
        if (other && other->begin < room.end && room.begin < other->end) {
            return {};
        }
    }
    return room;
}

void Placement::submit(std::size_t band) {
    std::unique_lock lock(mutex_);
    in_flight_[band].done = true;
    const BandOutput& own = *in_flight_[band].output;
    outgrown_ = outgrown_ || own.point_count > bands_[band].segments;
    if (own.in_buffer()) {
        placed_[band].room.reset();
    }
    // Places are fixed under the lock and buffers copied outside it; meanwhile another thread may place the next head.
    const std::size_t begin = head_;
    while (head_ < placed_.size() && in_flight_[head_].done &&
           clear_rooms(totals_.points + in_flight_[head_].output->point_count)) {
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
            give_back(b);
        }
    }
}

/// The head has outgrown its room and will reach to `end`: moves later bands that lie in its way to buffers. False if one of
/// them is still being swept: its thread will try again.
bool Placement::clear_rooms(std::uint64_t end) {
    for (std::size_t b = head_ + 1; b < begun_end(); ++b) {
        std::optional<Stretch>& room = placed_[b].room;
        if (room && room->begin < end) {
            assert(outgrown_);
            if (!in_flight_[b].done) {
                return false;
            }
            in_flight_[b].output->move_to_buffer(0);
            room.reset();
        }
    }
    return true;
}

void Placement::place_head() {
    Placed& placed = placed_[head_];
    BandOutput& output = *in_flight_[head_].output;
    placed.first_point = totals_.points;
    placed.first_contour = totals_.contours;
    placed.contours.swap(output.contours);
    placed.layer_contours.swap(output.layer_contours);
    placed.stitches.swap(output.stitches);
    if (placed.room && placed.room->begin != totals_.points) {
        assert(placed.room->begin > totals_.points);
        const std::size_t count = output.point_count;
        std::memmove(room_.points.data() + totals_.points, output.points, count * sizeof(Point));
        if (output.with_origins) {
            std::memmove(room_.origins.data() + totals_.points, output.origins, count * sizeof(PointOrigin));
        }
    }
    placed.room.reset();
    totals_.points += output.point_count;
    totals_.contours += placed.contours.size();
    totals_.stitches += placed.stitches.size();
    totals_.counts.add(output.counts);
    ++head_;
}

/// From a buffer to the band's place. False if they do not fit there.
bool Placement::copy_points(std::size_t band) const {
    const Placed& placed = placed_[band];
    const BandOutput& output = *in_flight_[band].output;
    const std::uint64_t capacity = room_.writer != nullptr ? room_.writer->capacity() : room_.points.size();
    const bool fits = placed.first_point + output.point_count <= capacity;
    if (fits && output.in_buffer() && output.point_count > 0) {
        StopPace pace;
        pace.follow(stop_);
        pace.in_stretches(0, output.point_count, 1, [&](std::size_t begin, std::size_t end) {
            if (room_.writer != nullptr) {
                room_.writer->write(placed.first_point + begin, {output.points + begin, output.points + end});
            } else {
                std::copy(output.points + begin, output.points + end, room_.points.data() + placed.first_point + begin);
            }
            if (output.with_origins) {
                std::copy(output.origins + begin, output.origins + end, room_.origins.data() + placed.first_point + begin);
            }
        });
    }
    return fits;
}

/// Kept is all that comes after some band: the points before it are where they belong.
void Placement::finish(const Parallel& parallel, SliceResult& result) {
    const auto first = static_cast<std::size_t>(
        std::find_if(in_flight_.begin(), in_flight_.end(), [](const InFlight& band) { return band.output != nullptr; }) -
        in_flight_.begin());
    const std::uint64_t in_place = first == placed_.size() ? totals_.points : placed_[first].first_point;
    extend(result.points, in_place, totals_.points, stop_);
    extend(result.origins, with_origins_ ? in_place : 0, with_origins_ ? totals_.points : 0, stop_);
    room_.points = result.points.span();
    room_.origins = result.origins.span();
    result.contours.resize_discarding(totals_.contours);
    parallel.run(bands_.size(), [&](std::size_t band, int) {
        if (BandOutput* const kept = in_flight_[band].output; kept != nullptr) {
            copy_points(band);
            kept->release();
        }
        write_band(band, result.contours.span(), result.layers.span(), parallel);
    });
    result.stitches.resize_discarding(totals_.stitches);
    write_stitches(result.stitches.span(), stop_);
}

void Placement::write_stitches(std::span<Stitch> gaps, const StopCheck& stop) const {
    StopPace pace;
    pace.follow(stop);
    Stitch* out = gaps.data();
    for (std::size_t b = 0; b < placed_.size(); ++b) {
        Stitch* const first = out;
        for (const Stitch& gap : placed_[b].stitches) {
            *out++ = {bands_[b].first + gap.layer, gap.from, gap.to};
        }
        std::sort(first, out, [&pace](const Stitch& a, const Stitch& b) {
            pace.spend(1);
            return std::tie(a.layer, a.from, a.to) < std::tie(b.layer, b.from, b.to);
        });
    }
}

void Placement::write_contours(const Parallel& parallel, std::span<Contour> contours, std::span<Layer> layers) const {
    assert(head_ == bands_.size());
    parallel.run(bands_.size(), [&](std::size_t band, int) { write_band(band, contours, layers, parallel); });
}

void Placement::write_band(std::size_t band, std::span<Contour> contours, std::span<Layer> layers,
                           const Parallel& parallel) const {
    constexpr std::size_t contours_between_stops = std::size_t{1} << 14;
    const Placed& placed = placed_[band];
    Contour* out = contours.data() + placed.first_contour;
    for (std::size_t c = 0; c < placed.contours.size(); ++c) {
        const Contour& contour = placed.contours[c];
        *out = contour;
        out->first_point += placed.first_point;
        out->parent += contour.parent < 0 ? 0 : static_cast<std::int64_t>(placed.first_contour);
        ++out;
        if (c % contours_between_stops == contours_between_stops - 1) {
            parallel.stop_if_asked();
        }
    }
    std::uint64_t first = placed.first_contour;
    for (PlaneIndex plane = bands_[band].first; plane < bands_[band].last; ++plane) {
        layers[plane].first_contour = first;
        layers[plane].contour_count = placed.layer_contours[plane - bands_[band].first];
        first += layers[plane].contour_count;
    }
}

void ResultTarget::admit(const OutputPlan& plan, std::uint64_t memory_limit) const {
    const std::uint64_t point_bytes = sizeof(Point) + (plan.origins ? sizeof(PointOrigin) : 0);
    const std::uint64_t bytes = plan.segments * point_bytes + plan.layers * sizeof(Layer) +
                                plan.result.info.layer_of.size() * sizeof(std::uint64_t) + plan.cutting * sizeof(Contour);
    if (bytes > memory_limit) {
        throw Refused{{ErrorCode::result_too_large,
                       counted(plan.layers, "layer") + " with " + counted(plan.segments, "segment") + " need " +
                           std::to_string(bytes) + " bytes, more than the memory limit of " + std::to_string(memory_limit)}};
    }
}

/// A closed contour has at most as many points as segments; an open one has one more, for which there is some room. What
/// very many open polylines have beyond that is kept until the array is made larger.
BandTarget& ResultTarget::begin(const OutputPlan& plan) {
    plan.result.points.resize_discarding(plan.segments + plan.segments / 64 + 64);
    Placement& placement = plan.scratch.placement;
    placement.begin(plan.bands, plan.lead, plan.origins, plan.result, plan.parallel.stop());
    return placement;
}

void ResultTarget::finish(const OutputPlan& plan) {
    SliceResult& result = plan.result;
    result.layers.resize_discarding(plan.layers);
    fill_layers(plan, result.layers.span());
    plan.scratch.placement.finish(plan.parallel, result);
    set_counts(plan.scratch.placement.totals().counts, result);
}

void move_to(const Memory* memory, SliceResult& result) {
    if (result.points.memory() != memory) {
        result = SliceResult(memory);
    }
}

void fill_layers(const OutputPlan& plan, std::span<Layer> layers) {
    plan.parallel.run_ranges(layers.size(), 1 << 10, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            layers[i] = plan.layer_at(static_cast<PlaneIndex>(i));
        }
    });
}

void describe_plan(const PlaneSet& planes, bool list_heights, SliceInfo& info) {
    const Vector<PlaneIndex>& listed = planes.plane_of_listed();
    info.layer_of.assign(listed.begin(), listed.end());
    if (list_heights) {
        info.options.heights_mm.emplace(planes.listed_mm().begin(), planes.listed_mm().end());
    }
    info.layers = planes.size();
    info.first_layer = planes.first_kept();
    info.planned_layers = planes.planned();
}

void add_work(const SliceInfo& part, SliceInfo& sum) noexcept {
    sum.triangles += part.triangles;
    sum.degenerate += part.degenerate;
    sum.crossed += part.crossed;
    sum.segments += part.segments;
    sum.bands += part.bands;
    sum.ms.bucket += part.ms.bucket;
    sum.ms.sweep += part.ms.sweep;
    sum.ms.contours += part.ms.contours;
    sum.ms.nesting += part.ms.nesting;
    sum.ms.fill += part.ms.fill;
}

}  // namespace lamella
