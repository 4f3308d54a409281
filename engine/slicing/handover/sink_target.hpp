// A slice that is made for a sink: its layers go there one by one, while bands are being swept.
//
// In any order a thread hands over each layer as it is built. In ascending order one thread at a time hands layers over: the
// one that sweeps the head, the first band that is not all handed over. Others keep their layers, up to their share of a
// window, and then wait to become the head:
//
//     band        0         1 (head)             2                3
//               [done]    [ L7 > sink ]   [ L8 L9 L10 ... ]    waits: its share is full
//
// The head never waits. With T threads that are spread evenly over their bands, half of all layers are kept, and T bands are
// begun beyond the head at most.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "lamella/destination.hpp"
#include "lamella/slice.hpp"
#include "slicing/result/layer_target.hpp"

namespace lamella {

/// The bands of one sweep.
class SinkBands final : public BandQueue {
public:
    SinkBands(const LayerSink& sink, const OutputPlan& plan);
    SinkBands(const SinkBands&) = delete;
    SinkBands& operator=(const SinkBands&) = delete;

    void submit(std::size_t band) override;
    void layer_done(BandOutput& output) override;

    const LayerTotals& totals() const noexcept { return totals_; }

    /// The bytes that a band may keep while it is not the head.
    static std::size_t share_of_band(int threads) noexcept;

private:
    void make_room(std::size_t band, BandOutput& output, std::unique_lock<std::mutex>& lock) override;
    void hand_over(BandOutput& output);
    /// In ascending order only the thread that sweeps the head hands over: a band becomes the head once, and remains it
    /// until it is done.
    bool is_head(std::size_t band) const noexcept { return !ascending_ || head_.load(std::memory_order_acquire) == band; }

    const LayerSink& sink_;
    const OutputPlan& plan_;
    const bool ascending_;
    const std::size_t share_;
    std::vector<LayerTotals> totals_of_;  // of each band
    LayerTotals totals_;
};

class SinkTarget final : public LayerTarget {
public:
    /// Throws Refused where the sink is none.
    explicit SinkTarget(const LayerSink& sink);

    std::uint64_t most_band_segments(int threads) const noexcept override {
        return sink_.order == SinkOrder::any || threads == 1 ? BandPlan::no_limit
                                                             : SinkBands::share_of_band(threads) / sizeof(Point);
    }
    BandTarget& begin(const OutputPlan& plan) override {
        announce(plan.result.info);
        plan.parallel.ask_host();
        return bands_.emplace(sink_, plan);
    }
    void finish(const OutputPlan& plan) override;

    /// Tells the sink what is known before the first layer: once, by whoever calls it first.
    void announce(const SliceInfo& info);

private:
    const LayerSink& sink_;
    bool is_announced_ = false;
    std::optional<SinkBands> bands_;
};

// A slice that is made for the host's own arrays, in its number type, scale and stride.

/// Grid points to the host's numbers.
class HostPoints final : public PointWriter {
public:
    /// `output` has passed the checks and outlives this.
    explicit HostPoints(const HostArrays& output) noexcept;

    std::uint64_t capacity() const noexcept override { return output_.point_capacity; }
    void write(std::uint64_t first, std::span<const Point> points) const noexcept override;

private:
    using Convert = void (*)(std::span<const Point> points, double scale, std::byte* to, std::size_t stride) noexcept;

    const HostArrays& output_;
    std::size_t stride_;
    Convert convert_;
};

class HostTarget final : public LayerTarget {
public:
    /// Throws Refused where arrays or scale make no sense.
    explicit HostTarget(const HostArrays& host);

    void admit_layers(std::uint64_t layers, const SliceInfo& info) const override;
    BandTarget& begin(const OutputPlan& plan) override;
    void finish(const OutputPlan& plan) override;

private:
    void check_room(const LayerTotals& totals) const;

    const HostArrays& host_;
    HostPoints writer_;
};

}  // namespace lamella
