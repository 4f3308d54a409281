// Grid points to the host's number type, scale and stride.
#pragma once

#include "lamella/host_output.hpp"
#include "slicing/result/point_writer.hpp"

namespace lamella {

/// Bytes of x and y.
std::size_t point_bytes(PointType type) noexcept;

/// Refuses arrays and scales that make no sense.
Status check_host(const HostOutput& output);

/// Refuses a scale by which a coordinate of at most `farthest` grid units may exceed the type.
Status check_scale(const HostOutput& output, double farthest);

/// Whether the points are those of the grid as they are in memory.
bool is_plain(const HostOutput& output) noexcept;

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

}  // namespace lamella
