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

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <variant>

#include "lamella/destination.hpp"
#include "lamella/slice.hpp"
#include "slicing/result/layer_target.hpp"

namespace lamella {

class SinkTarget final : public LayerTarget {
public:
    /// Throws Refused where the sink is none.
    explicit SinkTarget(const LayerSink& sink);

    void announce(const SliceInfo& info) override;
    std::uint64_t most_band_segments(int threads) const noexcept override;
    void begin(const OutputPlan& plan) override;
    void submit(std::size_t band) override;
    void layer_done(BandOutput& output) override;
    void finish() override { totals_.describe(plan_->info); }

private:
    void make_room(std::size_t band, BandOutput& output, std::unique_lock<std::mutex>& lock) override;
    void hand_over(BandOutput& output);
    /// In ascending order only the thread that sweeps the head hands over: a band becomes the head once, and remains it
    /// until it is done.
    bool is_head(std::size_t band) const noexcept { return !ascending_ || head_.load(std::memory_order_acquire) == band; }

    const LayerSink& sink_;
    const bool ascending_;
    bool is_announced_ = false;
    std::size_t share_ = 0;  ///< bytes that a band may keep while it is not the head
};

/// A slice that is made for the host's own arrays, in its number type, scale and stride.
class HostTarget final : public PlacedTarget {
public:
    /// Throws Refused where arrays or scale make no sense.
    explicit HostTarget(const HostArrays& host);

    void admit_layers(std::uint64_t layers, const SliceInfo& info) override;
    void begin(const OutputPlan& plan) override;
    void finish() override;

private:
    std::uint64_t capacity() const noexcept override { return host_.point_capacity; }
    void write(std::uint64_t first, std::span<const Point> points) const noexcept override;

    const HostArrays& host_;
    const std::size_t stride_;
    std::uint64_t layers_ = 0;  ///< of all plans
};

using AnyTarget = std::variant<std::monostate, ResultTarget, SinkTarget, HostTarget>;

/// The target that a destination stands for, made in `target`; null for no destination. Throws Refused where it makes no
/// sense.
inline LayerTarget* target_of(const Destination* to, const Memory* memory, AnyTarget& target) {
    if (to == nullptr) {
        return nullptr;
    }
    if (to->sink() != nullptr) {
        return &target.emplace<SinkTarget>(*to->sink());
    }
    if (to->arrays() != nullptr) {
        return &target.emplace<HostTarget>(*to->arrays());
    }
    if (to->result()->points.memory() != memory) {
        *to->result() = SliceResult(memory);
    }
    return &target.emplace<ResultTarget>(*to->result());
}

}  // namespace lamella
