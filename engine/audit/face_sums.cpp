#include "audit/face_sums.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "slicing/grid/exact.hpp"
#include "slicing/grid/mesh_edge.hpp"

namespace lamella {

namespace {

constexpr double limb_unit = 0x1p42;
constexpr double top_limb_unit = 0x1p84;
/// A limb has up to 2^42 from each corner, and a slab up to two corners of a face.
constexpr std::uint32_t faces_between_carries = std::uint32_t{1} << 18;
static_assert(CornerSums::limb_bits + 18 + 1 + 1 < 63, "a limb holds its sum until it is carried");

/// A hash of the edge from one to the other; that of its opposite is the negative.
std::uint64_t directed(std::uint64_t from, std::uint64_t to) noexcept {
    const std::uint64_t edge = mul_fold((from + to) ^ 0x94D049BB133111EBU, (from ^ to) ^ 0xD6E8FEB86659FD93U);
    return (std::uint64_t{from < to} - std::uint64_t{from > to}) * edge;
}

std::uint64_t boundary_of(const GridTriangle& t) noexcept {
    const std::array<std::uint64_t, 3> corners = {quick_hash_of(t[0]), quick_hash_of(t[1]), quick_hash_of(t[2])};
    return directed(corners[0], corners[1]) + directed(corners[1], corners[2]) + directed(corners[2], corners[0]);
}

std::array<std::int32_t, 3> ascending(std::int32_t a, std::int32_t b, std::int32_t c) noexcept {
    const std::int32_t low = std::min(a, b);
    const std::int32_t high = std::max(a, b);
    return {std::min(low, c), std::max(low, std::min(high, c)), std::max(high, c)};
}

// Four numbers side by side, which take one register where there is AVX2. Passed by reference: how they would be passed by
// value depends on the processor.
using Four = double __attribute__((vector_size(32)));
using FourWhole = std::int64_t __attribute__((vector_size(32)));
constexpr Four none = {};

/// Rounded to whole numbers, which are below 2^51: they then stand in the low bits of the sum.
constexpr double rounding_shift = 0x1.8p52;

[[gnu::always_inline]] inline void add_rounded(std::int64_t* at, const Four& shifted) {
    FourWhole sum;
    std::memcpy(&sum, at, sizeof sum);
    sum += reinterpret_cast<FourWhole>(shifted) - std::bit_cast<std::int64_t>(rounding_shift);
    std::memcpy(at, &sum, sizeof sum);
}

[[gnu::always_inline]] inline void add_limbs(std::int64_t* low, std::int64_t* middle, std::int64_t* top, const Four& value) {
    const Four top_limb = value * (1 / top_limb_unit) + rounding_shift;
    const Four rest = value - (top_limb - rounding_shift) * top_limb_unit;
    const Four middle_limb = rest * (1 / limb_unit) + rounding_shift;
    add_rounded(top, top_limb);
    add_rounded(middle, middle_limb);
    add_rounded(low, rest - (middle_limb - rounding_shift) * limb_unit + rounding_shift);
}

/// Four slabs at a time, always the same four: what one face stores the next one loads, and a load that spans two stores
/// would wait for both.
template <bool rises>
[[gnu::always_inline]] inline void add_corner(const double* z, const FaceCorner& corner, CornerSums& sums) {
    const Four base = none + corner.base;
    for (std::size_t s = corner.first - corner.first % CornerSums::lanes; s <= corner.last; s += CornerSums::lanes) {
        Four above;
        Four below;
        std::memcpy(&above, z + s, sizeof above);
        std::memcpy(&below, z + static_cast<std::ptrdiff_t>(s) - 1, sizeof below);
        // From the apex, within one slab: where the corner ends, and where it entered the slab.
        const Four to = rises ? (above < base ? above : base) - corner.apex : corner.apex - (below > base ? below : base);
        const Four entered = rises ? below - corner.apex : corner.apex - above;
        const Four from = entered > none ? entered : none;
        const Four square = to * to;
        const Four square_from = from * from;
        const FourWhole number = FourWhole{0, 1, 2, 3} + static_cast<std::int64_t>(s);
        const FourWhole begun = number >= std::int64_t{corner.first};
        const FourWhole slabs = begun & (number <= std::int64_t{corner.last});
        const FourWhole planes = begun & (number < std::int64_t{corner.last});
        const Four volume = corner.volume_bend * (to - from) * (square + to * from + square_from);
        const Four area = corner.area_bend * (rises ? square : square_from);
        add_limbs(sums.volumes(0) + s, sums.volumes(1) + s, sums.volumes(2) + s, slabs ? volume : none);
        add_limbs(sums.areas(0) + s, sums.areas(1) + s, sums.areas(2) + s, planes ? area : none);
    }
}

template <bool rises>
void add_corner_portable(const double* z, const FaceCorner& corner, CornerSums& sums) {
    add_corner<rises>(z, corner, sums);
}

#ifdef LAMELLA_X86_FORMS
template <bool rises>
LAMELLA_AVX2 void add_corner_avx2(const double* z, const FaceCorner& corner, CornerSums& sums) {
    add_corner<rises>(z, corner, sums);
}
#endif

constexpr Form<CornerKernels> forms_of_corners[] = {
#ifdef LAMELLA_X86_FORMS
    {InstructionSet::avx2, {add_corner_avx2<true>, add_corner_avx2<false>}},
#endif
    {InstructionSet::portable, {add_corner_portable<true>, add_corner_portable<false>}}};

}  // namespace

std::span<const Form<CornerKernels>> corner_kernel_forms() noexcept {
    return forms_of_corners;
}

PlaneHeights::PlaneHeights(const PlaneSet& planes) : padded_(planes.size() + 2 * room, 0x1p31) {
    std::fill_n(padded_.begin(), room, -0x1p31);
    for (PlaneIndex i = 0; i < planes.size(); ++i) {
        padded_[i + room] = planes.z(i);
    }
}

CornerSums::CornerSums(std::size_t planes) : stride_((planes + 1 + lanes - 1) / lanes * lanes), limbs_(6 * stride_, 0) {}

Int128 CornerSums::number_at(std::size_t at) const noexcept {
    return limbs_[at] + (Int128{limbs_[at + stride_]} << limb_bits) + (Int128{limbs_[at + 2 * stride_]} << (2 * limb_bits));
}

void CornerSums::carry() noexcept {
    constexpr std::int64_t mask = (std::int64_t{1} << limb_bits) - 1;
    for (const std::size_t first : {std::size_t{0}, 3 * stride_}) {
        for (std::size_t i = first; i < first + 2 * stride_; ++i) {  // low limbs, then middle ones
            limbs_[i + stride_] += limbs_[i] >> limb_bits;
            limbs_[i] &= mask;
        }
    }
}

FaceSums::FaceSums(const PlaneSet& planes, const PlaneHeights& heights, CornerScale scale)
    : planes_(planes),
      z_(heights.z()),
      kernels_(best_of(corner_kernel_forms())),
      area_scale_(std::ldexp(1.0, scale.area_bits)),
      volume_scale_(std::ldexp(1.0, scale.volume_bits)),
      corners_(planes.size()),
      wholes_(planes.size() + 1) {}

void FaceSums::add(const GridTriangle& t) noexcept {
    edges_ += boundary_of(t);
    if (is_degenerate(t)) {
        return;
    }
    const std::array<GridVector, 3> halves = {half(t[0]), half(t[1]), half(t[2])};
    const std::int64_t covered = cross(halves[1] - halves[0], halves[2] - halves[0]).z;
    six_volumes_ += dot(cross(halves[0], halves[1]), halves[2]);
    const std::array<std::int32_t, 3> z = ascending(t[0].z, t[1].z, t[2].z);
    const std::array<PlaneIndex, 3> above = {planes_.first_above(z[0]), planes_.first_above(z[1]),
                                             planes_.first_above(z[2])};
    ++wholes_[above[0]].cut;
    --wholes_[above[2]].cut;
    wholes_[above[1]].step += covered;
    wholes_[above[1]].lever += Int128{covered} * z[1];
    if (covered != 0 && z[0] != z[2]) {
        add_corners(covered, z, above);
    }
}

/// The face is neither upright nor level; all is by height.
void FaceSums::add_corners(std::int64_t covered, const std::array<std::int32_t, 3>& z,
                           const std::array<PlaneIndex, 3>& above) noexcept {
    const std::int64_t height = std::int64_t{z[2]} - z[0];
    const double share = static_cast<double>(covered) / static_cast<double>(height);
    reach_ += Int128{std::abs(covered)} * height;
    if (z[0] != z[1]) {
        kernels_.rising(z_, corner_of(share, z[0], z[1], above[0], above[1]), corners_);
    }
    if (z[1] != z[2]) {
        kernels_.falling(z_, corner_of(-share, z[2], z[1], above[1], above[2]), corners_);
    }
    if (++since_carry_ == faces_between_carries) {
        since_carry_ = 0;
        corners_.carry();
    }
}

FaceCorner FaceSums::corner_of(double share, std::int32_t apex, std::int32_t base, PlaneIndex first,
                               PlaneIndex last) const noexcept {
    const double bend = share / std::abs(static_cast<double>(base) - apex);
    return {static_cast<double>(apex), static_cast<double>(base), bend * area_scale_, bend * volume_scale_ / 3, first, last};
}

void FaceSums::add_to(PlaneSums& all, std::size_t plane) const noexcept {
    all.area += corners_.area(plane);
    all.volume += corners_.volume(plane);
    all.step += wholes_[plane].step;
    all.lever += wholes_[plane].lever;
    all.cut += wholes_[plane].cut;
}

}  // namespace lamella
