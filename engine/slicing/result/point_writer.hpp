// Where points go that are not to be kept as they are.
#pragma once

#include <cstdint>
#include <span>

#include "lamella/grid.hpp"

namespace lamella {

class PointWriter {
public:
    /// How many points there is room for.
    virtual std::uint64_t capacity() const noexcept = 0;
    /// The points from number `first` on; by several threads at once, no point twice.
    virtual void write(std::uint64_t first, std::span<const Point> points) const noexcept = 0;

protected:
    ~PointWriter() = default;
};

}  // namespace lamella
