#include "slicing/handover/sink_bands.hpp"

#include <algorithm>
#include <utility>

namespace lamella {

namespace {

constexpr std::size_t window_bytes = std::size_t{1} << 26;
constexpr std::size_t parcel_bytes = std::size_t{1} << 20;
constexpr std::size_t parcel_points = parcel_bytes / sizeof(Point);

/// Outputs that are not in use keep at most so much memory.
constexpr std::size_t most_idle_bytes = window_bytes / 2;

}  // namespace

SinkBands::SinkBands(const LayerSink& sink, const SweepInput& input)
    : handout_(sink, input), input_(input), bands_(input.bands.size()) {
    for (const auto& output : input.scratch.outputs) {
        put_idle(output.get());
    }
}

BandOutput* SinkBands::begin_band(std::size_t band) {
    BandOutput* const output = take_idle();
    output->first_layer = input_.bands[band].first;
    output->reader = this;
    output->band = band;
    bands_[band].output = output;
    // All layers of a wide plane's band, which is one; of others a parcel, or the largest layer as it comes.
    const std::uint64_t segments = input_.bands[band].segments;
    output->with_origins = input_.origins;
    output->begin({});
    output->make_room(input_.bands[band].wide ? segments : std::min<std::uint64_t>(segments, parcel_points));
    return output;
}

BandOutput* SinkBands::take_idle() {
    auto& outputs = input_.scratch.outputs;
    if (idle_.empty()) {
        outputs.push_back(std::make_unique<BandOutput>(input_.scratch.memory));
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

double SinkBands::end_band(std::size_t band) {
    OwnBand& own = bands_[band];
    own.own.counts = own.output->counts;
    total_.add(own.own);
    put_idle(std::exchange(own.output, nullptr));
    segments_done_ += input_.bands[band].segments;
    const std::uint64_t all = input_.buckets.segment_count;
    return all == 0 ? 1.0 : static_cast<double>(segments_done_) / static_cast<double>(all);
}

// --- Any order

BandOutput* AnyOrderBands::acquire(std::size_t band) {
    const std::lock_guard lock(mutex_);
    return aborted_ ? nullptr : begin_band(band);
}

void AnyOrderBands::layer_done(BandOutput& output) {
    handout_.hand_over(output, bands_[output.band].own);
}

void AnyOrderBands::submit(std::size_t band) {
    layer_done(*bands_[band].output);
    std::unique_lock lock(mutex_);
    const double fraction = end_band(band);
    lock.unlock();
    input_.progress.reach(fraction);
}

// --- Ascending order

AscendingBands::AscendingBands(const LayerSink& sink, const SweepInput& input)
    : SinkBands(sink, input), lead_(2 * static_cast<std::size_t>(input.parallel.threads())) {}

std::uint64_t AscendingBands::most_segments(int threads) noexcept {
    return threads == 1 ? BandPlan::no_limit : 4 * window_bytes / sizeof(Point) / static_cast<std::uint64_t>(threads);
}

BandOutput* AscendingBands::acquire(std::size_t band) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return aborted_ || band <= head_ + lead_; });
    return aborted_ ? nullptr : begin_band(band);
}

/// Only the thread that sweeps the head hands over: a band becomes the head once, and remains it until it is done.
void AscendingBands::layer_done(BandOutput& output) {
    if (head_.load(std::memory_order_acquire) == output.band) {
        hand_over(bands_[output.band]);
    } else if (output.bytes_used() >= parcel_bytes) {
        put_aside(output);
    }
}

/// Waits until there is memory, or the band is the head.
void AscendingBands::put_aside(BandOutput& output) {
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
    output.make_room(parcel_points);
}

/// What was put aside, then what the output holds. The band is the head.
void AscendingBands::hand_over(OwnBand& band) {
    for (BandOutput* const parcel : band.parcels) {
        const std::size_t bytes = parcel->bytes_held();
        handout_.hand_over(*parcel, band.own);
        {
            const std::lock_guard lock(mutex_);
            bytes_aside_ -= bytes;
            put_idle(parcel);
        }
        changed_.notify_all();
    }
    band.parcels.clear();
    handout_.hand_over(*band.output, band.own);
}

/// Where the band is the head, hands over what is left of it and of all done bands that follow. While it does so no other
/// thread can: the next head is either done, or its own thread will find that it is the head.
void AscendingBands::submit(std::size_t band) {
    BandOutput& output = *bands_[band].output;
    if (head_.load(std::memory_order_acquire) != band && output.bytes_used() > parcel_bytes / 16) {
        put_aside(output);
    }
    std::unique_lock lock(mutex_);
    bands_[band].done = true;
    if (head_ != band) {
        return;
    }
    bool is_done = true;
    for (std::size_t head = band; is_done; ++head) {
        lock.unlock();
        hand_over(bands_[head]);
        lock.lock();
        const double fraction = end_band(head);
        head_.store(head + 1, std::memory_order_release);
        is_done = head + 1 < bands_.size() && bands_[head + 1].done;
        lock.unlock();
        changed_.notify_all();
        input_.progress.reach(fraction);
        lock.lock();
    }
}

}  // namespace lamella
