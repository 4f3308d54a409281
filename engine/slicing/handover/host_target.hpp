// A slice that is made for the host's own arrays, in its number type, scale and stride.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "lamella/destination.hpp"
#include "lamella/slice.hpp"
#include "slicing/result/layer_target.hpp"

namespace lamella {

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
