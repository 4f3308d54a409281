// A slice that is made for the host's own arrays, in its number type, scale and stride.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "lamella/host_output.hpp"
#include "slicing/result/layer_target.hpp"

namespace lamella {

/// Grid points to the host's numbers.
class HostPoints final : public PointWriter {
public:
    /// `output` has passed the checks and outlives this.
    explicit HostPoints(const HostOutput& output) noexcept;

    std::uint64_t capacity() const noexcept override { return output_.point_capacity; }
    void write(std::uint64_t first, std::span<const Point> points) const noexcept override;

private:
    using Convert = void (*)(std::span<const Point> points, double scale, std::byte* to, std::size_t stride) noexcept;

    const HostOutput& output_;
    std::size_t stride_;
    Convert convert_;
};

class HostTarget final : public LayerTarget {
public:
    /// Throws Refused where arrays or scale make no sense.
    explicit HostTarget(const HostOutput& host);

    void admit(const SweepInput& input, std::uint64_t memory_limit) override;
    BandTarget& begin(const SweepInput& input) override;
    void finish(const SweepInput& input) override;

    SliceTotals totals(SliceResult& result) const;

private:
    void check_room(const Placement& placement) const;

    const HostOutput& host_;
    HostPoints writer_;
    std::uint64_t layers_ = 0;
    std::uint64_t contours_ = 0;
    std::uint64_t points_ = 0;
    std::uint64_t closed_gaps_ = 0;
};

}  // namespace lamella
