// Bands that go to a sink, layer by layer, while they are being swept.
//
// In ascending order one thread at a time hands layers over: the one that sweeps the head, the first band that is not all
// handed over. Others put their layers aside in parcels of about a megabyte, and wait for memory or to become the head:
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
#include <vector>

#include "slicing/handover/layer_handout.hpp"

namespace lamella {

/// What the two orders share: outputs by band, and what was handed over.
class SinkBands : public BandTarget, protected LayerReader {
public:
    SinkBands(const LayerSink& sink, const SweepInput& input);
    SinkBands(const SinkBands&) = delete;
    SinkBands& operator=(const SinkBands&) = delete;

    void give_back(std::size_t band) override;
    void abort() override;
    const HandedOver& handed_over() const noexcept { return total_; }

protected:
    struct OwnBand {
        BandOutput* output = nullptr;
        std::vector<BandOutput*> parcels;  ///< layers put aside, in order
        HandedOver own;
        bool done = false;
    };

    ~SinkBands() = default;

    // With mutex_ held:
    BandOutput* begin_band(std::size_t band);
    BandOutput* take_idle();
    void put_idle(BandOutput* output);
    double end_band(std::size_t band);  ///< gives the progress

    const LayerHandout handout_;
    const SweepInput& input_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<OwnBand> bands_;
    bool aborted_ = false;

private:
    std::vector<BandOutput*> idle_;
    std::size_t idle_bytes_ = 0;
    HandedOver total_;
    std::uint64_t segments_done_ = 0;
};

class AnyOrderBands final : public SinkBands {
public:
    using SinkBands::SinkBands;
    BandOutput* acquire(std::size_t band) override;
    void submit(std::size_t band) override;

private:
    void layer_done(BandOutput& output) override;
};

class AscendingBands final : public SinkBands {
public:
    AscendingBands(const LayerSink& sink, const SweepInput& input);

    BandOutput* acquire(std::size_t band) override;
    void submit(std::size_t band) override;

    /// How many segments a band should have at most, so that the window holds what threads put aside.
    static std::uint64_t most_segments(int threads) noexcept;

private:
    void layer_done(BandOutput& output) override;
    void put_aside(BandOutput& output);
    void hand_over(OwnBand& band);

    const std::size_t lead_;            ///< how many bands beyond the head may be begun
    std::atomic<std::size_t> head_{0};  ///< written with mutex_ held
    std::size_t bytes_aside_ = 0;
};

}  // namespace lamella
