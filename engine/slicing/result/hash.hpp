// hash_result() of a result that comes in parts, or layer by layer.
#pragma once

#include <cstdint>
#include <span>

#include "lamella/result.hpp"

namespace lamella {

class ResultHash {
public:
    /// For so many layers.
    explicit ResultHash(std::uint64_t layers) noexcept { add(layers); }

    /// The next ones, in their order.
    void add_layers(const SliceResult& result) noexcept;
    /// The next one; `points` is what Contour::first_point counts from, Layer::first_contour what Contour::parent does.
    void add_layer(const Layer& layer, std::span<const Contour> contours, const Point* points) noexcept;
    std::uint64_t value() const noexcept { return state_; }

private:
    /// FNV-1a with a whole 64-bit word where the original takes a byte: one multiplication a point.
    void add(std::uint64_t word) noexcept { state_ = (state_ ^ word) * 0x100000001b3U; }
    void add_signed(std::int64_t word) noexcept { add(static_cast<std::uint64_t>(word)); }
    void add_contour(const Layer& layer, const Contour& contour, const Point* points) noexcept;

    std::uint64_t state_ = 0xcbf29ce484222325U;
};

}  // namespace lamella
