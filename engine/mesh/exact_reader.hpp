// Triangles by their coordinates as they are, without grid or transform.
#pragma once

#include <bit>
#include <cstdint>

#include "base/numbers.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// Vertices that are equal only where their coordinates are: the bits of floats, and of doubles a hash of 96 bits, which
/// two of 10^9 different vertices share by a chance of 10^-11.
class ExactReader {
public:
    explicit ExactReader(const MeshView& mesh) noexcept : read_(mesh, {}) {}

    GridTriangle operator()(std::size_t t) const noexcept {
        const RawTriangle raw = read_(t);
        return {vertex(raw.v), vertex(raw.v + 3), vertex(raw.v + 6)};
    }

private:
    GridVertex vertex(const double* xyz) const noexcept {
        const double x = xyz[0] + 0.0;  // makes a positive zero of a negative one
        const double y = xyz[1] + 0.0;
        const double z = xyz[2] + 0.0;
        if (read_.number() == CoordinateType::f32) {
            const auto bits = [](double value) { return std::bit_cast<std::int32_t>(static_cast<float>(value)); };
            return {bits(x), bits(y), bits(z)};
        }
        const auto hash = [&](std::uint64_t seed) {
            return mix64(std::bit_cast<std::uint64_t>(x) ^
                         mix64(std::bit_cast<std::uint64_t>(y) ^ mix64(std::bit_cast<std::uint64_t>(z) ^ seed)));
        };
        const std::uint64_t first = hash(1);
        return {static_cast<std::int32_t>(first), static_cast<std::int32_t>(first >> 32),
                static_cast<std::int32_t>(hash(2))};
    }

    PlacedReader read_;
};

}  // namespace lamella
