// A slice that is made for a sink: its layers go there one by one, while bands are being swept.
//
// In any order a thread hands over each layer as it is built. In ascending order one thread at a time hands layers over: the
// one that sweeps the head, the first band that is not all handed over. Others put their layers aside in parcels of about a
// megabyte, and wait for memory or to become the head:
//
//     band        0         1 (head)             2                    3
//               [done]    [ L7 > sink ]   [ L8 L9 | L10 ... ]      waits: not yet two bands a thread, but no memory left
//                                          parcels  being filled
//
// The head never waits, so parcels always come free. With T threads that are spread evenly over their bands, half of all
// layers are put aside, and a window of (T - 1) / 2 bands keeps every thread at work.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "lamella/destination.hpp"
#include "lamella/slice.hpp"
#include "slicing/result/layer_target.hpp"

namespace lamella {

/// The bands of one sweep.
class SinkBands final : public BandTarget {
public:
    SinkBands(const LayerSink& sink, const OutputPlan& plan);
    SinkBands(const SinkBands&) = delete;
    SinkBands& operator=(const SinkBands&) = delete;

    BandOutput* acquire(std::size_t band) override;
    void give_back(std::size_t band) override;
    void submit(std::size_t band) override;
    void abort() override;
    void layer_done(BandOutput& output) override;

    const LayerTotals& totals() const noexcept { return totals_; }

    /// How many segments a band should have at most, so that the window holds what threads put aside.
    static std::uint64_t most_segments(int threads) noexcept;

private:
    struct OwnBand {
        BandOutput* output = nullptr;
        std::vector<BandOutput*> parcels;  ///< layers put aside, in order
        LayerTotals totals;
        bool done = false;
    };

    void put_aside(BandOutput& output);
    void hand_over(OwnBand& band);
    void hand_over(BandOutput& output, LayerTotals& totals) const;
    /// In ascending order only the thread that sweeps the head hands over: a band becomes the head once, and remains it
    /// until it is done.
    bool is_head(std::size_t band) const noexcept { return !ascending_ || head_.load(std::memory_order_acquire) == band; }

    // With mutex_ held:
    BandOutput* take_idle();
    void put_idle(BandOutput* output);
    void end_band(std::size_t band);

    const LayerSink& sink_;
    const OutputPlan& plan_;
    const bool ascending_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<OwnBand> bands_;
    std::atomic<std::size_t> head_{0};  ///< written with mutex_ held
    std::size_t bytes_aside_ = 0;
    bool aborted_ = false;
    std::vector<BandOutput*> idle_;
    std::size_t idle_bytes_ = 0;
    LayerTotals totals_;
};

class SinkTarget final : public LayerTarget {
public:
    /// Throws Refused where the sink is none.
    explicit SinkTarget(const LayerSink& sink);

    std::uint64_t most_band_segments(int threads) const noexcept override {
        return sink_.order == SinkOrder::any ? BandPlan::no_limit : SinkBands::most_segments(threads);
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

}  // namespace lamella
