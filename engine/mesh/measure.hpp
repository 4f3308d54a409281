// Measures and counts of a mesh, for check() and orient_shells().
#pragma once

#include <bit>
#include <cstdint>

#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "lamella/check.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// Triangles by their coordinates as they are, without grid or transform. Vertices are equal only where their coordinates
/// are: the bits of floats, and of doubles a hash of 96 bits, which two of 10^9 different vertices share by a chance of
/// 10^-11.
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
        if (read_.number() == Number::f32) {
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

/// Fills in the mesh's box, grid, volume, area and number of triangles. Two calls of run(), which lead the progress on to
/// `progress`. O(n). The sums do not depend on threads. Throws Refused.
void measure_mesh(const MeshView& mesh, const Frame& frame, const Parallel& parallel, double progress, MeshCheck& check);

/// Fills in what `check` counts, by the faces that meet at each edge (paper 1.3: closed meshes). Triangles with two vertices
/// at one place are left out. Six calls of run(), or twelve where the grid joins vertices or lets triangles collapse. O(n)
/// expected; 16 bytes a triangle (32 from 2^32 / 3 triangles on) and up to two more beside the mesh. The counts do not
/// depend on threads. Precondition: indices in range, coordinates within the grid that `check` names. Throws std::bad_alloc.
void count_edges(const MeshView& mesh, const Frame& frame, const Parallel& parallel, MeshCheck& check);

/// MeshCheck::exact_boundary_edges alone. As much work as all of count_edges().
std::uint64_t count_exact_boundary(const MeshView& mesh, const Parallel& parallel);

}  // namespace lamella
