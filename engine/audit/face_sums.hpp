// Areas that the faces of a mesh and their corners cover below each plane, for the certificate of areas and volumes
// (volume.cpp says what for). All sums are of whole numbers, so that they are the same in any order.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/dispatch.hpp"
#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// How many fractional bits corners keep. With them a sum over all faces stays below 2^125.
struct CornerScale {
    int area_bits;
    int volume_bits;
};

/// Heights of planes as doubles, with room for vectors of four that begin or end beyond them.
class PlaneHeights {
public:
    explicit PlaneHeights(const PlaneSet& planes);
    /// z of plane i; lower than any vertex below the first plane, higher above the last.
    const double* z() const noexcept { return padded_.data() + room; }

private:
    static constexpr std::size_t room = 4;
    std::vector<double> padded_;
};

/// Sums of whole numbers below 2^126, for each plane an area and for each slab a volume. A number is kept in three limbs of
/// 42 bits, in an array each, so that vectors of planes are added without carries:
///
///     number = limb 0 + limb 1 * 2^42 + limb 2 * 2^84
class CornerSums {
public:
    static constexpr int limb_bits = 42;
    static constexpr std::size_t lanes = 4;

    explicit CornerSums(std::size_t planes);

    /// Limb i of plane 0's area, and of the slab below it.
    std::int64_t* areas(std::size_t i) noexcept { return limbs_.data() + i * stride_; }
    std::int64_t* volumes(std::size_t i) noexcept { return limbs_.data() + (i + 3) * stride_; }

    Int128 area(std::size_t plane) const noexcept { return number_at(plane); }
    Int128 volume(std::size_t slab) const noexcept { return number_at(3 * stride_ + slab); }
    /// After which each limb is small again.
    void carry() noexcept;

private:
    Int128 number_at(std::size_t at) const noexcept;

    std::size_t stride_;
    std::vector<std::int64_t> limbs_;
};

/// A corner of a face, from its apex to the height where the face is widest. It covers bend * t^2 at t from the apex.
struct FaceCorner {
    double apex;
    double base;
    double area_bend;
    double volume_bend;  ///< a third, for the volume up to t
    PlaneIndex first;    ///< slabs [first, last] that it reaches into, and planes [first, last)
    PlaneIndex last;
};

/// Adds a corner to `sums`; each number is rounded towards zero, so that opposite faces cancel.
using AddCorner = void (*)(const double* z, const FaceCorner& corner, CornerSums& sums);
struct CornerKernels {
    AddCorner rising;   ///< for corners whose apex is their lowest point
    AddCorner falling;  ///< or its highest
};
/// For tests; FaceSums takes the best.
std::span<const Form<CornerKernels>> corner_kernel_forms() noexcept;

/// Sums for one plane and the slab below it. Squares have sides of two units, heights are in units.
struct PlaneSums {
    Int128 area = 0;       ///< by corners, at the plane
    Int128 volume = 0;     ///< by corners, within the slab
    Int128 step = 0;       ///< by faces that are whole from within the slab on
    Int128 lever = 0;      ///< the same, times the heights from which on
    std::int64_t cut = 0;  ///< faces that the plane is the first to cut, less those that it is the first to miss
};

/// The sums of one worker.
class alignas(worker_alignment) FaceSums {
public:
    FaceSums(const PlaneSet& planes, const PlaneHeights& heights, CornerScale scale);

    void add(const GridTriangle& t) noexcept;
    void add_to(PlaneSums& all, std::size_t plane) const noexcept;

    Int128 six_volumes() const noexcept { return six_volumes_; }  ///< tetrahedra, in cubes of two units
    Int128 reach() const noexcept { return reach_; }  ///< area times height of all faces: their corners cannot be larger
    std::uint64_t edges() const noexcept { return edges_; }  ///< hash of directed edges; opposite ones cancel

private:
    struct Wholes {
        Int128 step = 0;
        Int128 lever = 0;
        std::int64_t cut = 0;
    };

    void add_corners(std::int64_t covered, const std::array<std::int32_t, 3>& z,
                     const std::array<PlaneIndex, 3>& above) noexcept;
    FaceCorner corner_of(double share, std::int32_t apex, std::int32_t base, PlaneIndex first,
                         PlaneIndex last) const noexcept;

    const PlaneSet& planes_;
    const double* z_;
    const CornerKernels& kernels_;
    double area_scale_;
    double volume_scale_;
    CornerSums corners_;
    std::vector<Wholes> wholes_;
    std::uint32_t since_carry_ = 0;
    Int128 six_volumes_ = 0;
    Int128 reach_ = 0;
    std::uint64_t edges_ = 0;
};

}  // namespace lamella
