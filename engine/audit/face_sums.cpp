#include "audit/face_sums.hpp"

#include <algorithm>
#include <cmath>

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

/// From the apex, within one slab: where the corner ends, and where it entered the slab.
struct Stretch {
    double to;
    double from;
};

template <bool rises>
Stretch stretch_within(const double* z, const FaceCorner& corner, std::size_t slab) noexcept {
    const double below = z[static_cast<std::ptrdiff_t>(slab) - 1];
    return rises ? Stretch{std::min(z[slab], corner.base) - corner.apex, std::max(below - corner.apex, 0.0)}
                 : Stretch{corner.apex - std::max(below, corner.base), std::max(corner.apex - z[slab], 0.0)};
}

void add_limbs(std::int64_t* low, std::int64_t* middle, std::int64_t* top, double value) noexcept {
    const auto top_limb = static_cast<std::int64_t>(value / top_limb_unit);
    const double rest = value - static_cast<double>(top_limb) * top_limb_unit;
    const auto middle_limb = static_cast<std::int64_t>(rest / limb_unit);
    *top += top_limb;
    *middle += middle_limb;
    *low += static_cast<std::int64_t>(rest - static_cast<double>(middle_limb) * limb_unit);
}

template <bool rises>
void add_corner_portable(const double* z, const FaceCorner& corner, CornerSums& sums) {
    for (std::size_t s = corner.first; s <= corner.last; ++s) {
        const auto [to, from] = stretch_within<rises>(z, corner, s);
        const double square = to * to;
        const double square_from = from * from;
        add_limbs(sums.volumes(0) + s, sums.volumes(1) + s, sums.volumes(2) + s,
                  corner.volume_bend * (to - from) * (square + to * from + square_from));
        if (s < corner.last) {
            add_limbs(sums.areas(0) + s, sums.areas(1) + s, sums.areas(2) + s,
                      corner.area_bend * (rises ? square : square_from));
        }
    }
}

#ifdef LAMELLA_X86_FORMS

/// Precondition: whole, and below 2^51.
LAMELLA_AVX2_INLINE __m256i whole_lanes(__m256d value) {
    const __m256d shift = _mm256_set1_pd(0x1.8p52);  // the number then stands in the low bits of the sum
    return _mm256_sub_epi64(_mm256_castpd_si256(_mm256_add_pd(value, shift)), _mm256_castpd_si256(shift));
}

LAMELLA_AVX2_INLINE __m256d towards_zero(__m256d value) {
    return _mm256_round_pd(value, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
}

LAMELLA_AVX2_INLINE void add_lanes(std::int64_t* at, __m256d whole) {
    auto* const lanes = reinterpret_cast<__m256i*>(at);
    _mm256_storeu_si256(lanes, _mm256_add_epi64(_mm256_loadu_si256(lanes), whole_lanes(whole)));
}

LAMELLA_AVX2_INLINE void add_limb_lanes(std::int64_t* low, std::int64_t* middle, std::int64_t* top, __m256d value) {
    const __m256d top_unit = _mm256_set1_pd(top_limb_unit);
    const __m256d unit = _mm256_set1_pd(limb_unit);
    const __m256d top_limb = towards_zero(_mm256_mul_pd(value, _mm256_set1_pd(1 / top_limb_unit)));
    const __m256d rest = _mm256_sub_pd(value, _mm256_mul_pd(top_limb, top_unit));
    const __m256d middle_limb = towards_zero(_mm256_mul_pd(rest, _mm256_set1_pd(1 / limb_unit)));
    add_lanes(top, top_limb);
    add_lanes(middle, middle_limb);
    add_lanes(low, towards_zero(_mm256_sub_pd(rest, _mm256_mul_pd(middle_limb, unit))));
}

/// Four slabs at a time, always the same four: what one face stores the next one loads, and a load that spans two stores
/// would wait for both.
template <bool rises>
LAMELLA_AVX2 void add_corner_avx2(const double* z, const FaceCorner& corner, CornerSums& sums) {
    const __m256d apex = _mm256_set1_pd(corner.apex);
    const __m256d base = _mm256_set1_pd(corner.base);
    const __m256d area_bend = _mm256_set1_pd(corner.area_bend);
    const __m256d volume_bend = _mm256_set1_pd(corner.volume_bend);
    const __m256d zero = _mm256_setzero_pd();
    const __m256i before = _mm256_set1_epi64x(std::int64_t{corner.first} - 1);
    const __m256i last = _mm256_set1_epi64x(corner.last);
    for (std::size_t s = corner.first - corner.first % CornerSums::lanes; s <= corner.last; s += CornerSums::lanes) {
        const __m256d above = _mm256_loadu_pd(z + s);
        const __m256d below = _mm256_loadu_pd(z + static_cast<std::ptrdiff_t>(s) - 1);
        const __m256d to =
            rises ? _mm256_sub_pd(_mm256_min_pd(above, base), apex) : _mm256_sub_pd(apex, _mm256_max_pd(below, base));
        const __m256d from = _mm256_max_pd(rises ? _mm256_sub_pd(below, apex) : _mm256_sub_pd(apex, above), zero);
        const __m256d square = _mm256_mul_pd(to, to);
        const __m256d square_from = _mm256_mul_pd(from, from);
        const __m256d volume = _mm256_mul_pd(_mm256_mul_pd(volume_bend, _mm256_sub_pd(to, from)),
                                             _mm256_add_pd(_mm256_add_pd(square, _mm256_mul_pd(to, from)), square_from));
        const __m256d area = _mm256_mul_pd(area_bend, rises ? square : square_from);
        const __m256i number =
            _mm256_add_epi64(_mm256_set1_epi64x(static_cast<std::int64_t>(s)), _mm256_setr_epi64x(0, 1, 2, 3));
        const __m256i begun = _mm256_cmpgt_epi64(number, before);
        const __m256i slabs = _mm256_andnot_si256(_mm256_cmpgt_epi64(number, last), begun);
        const __m256i planes = _mm256_and_si256(_mm256_cmpgt_epi64(last, number), begun);
        add_limb_lanes(sums.volumes(0) + s, sums.volumes(1) + s, sums.volumes(2) + s,
                       _mm256_and_pd(volume, _mm256_castsi256_pd(slabs)));
        add_limb_lanes(sums.areas(0) + s, sums.areas(1) + s, sums.areas(2) + s,
                       _mm256_and_pd(area, _mm256_castsi256_pd(planes)));
    }
}

constexpr Form<CornerKernels> forms_of_corners[] = {
    {InstructionSet::avx2, {add_corner_avx2<true>, add_corner_avx2<false>}},
    {InstructionSet::portable, {add_corner_portable<true>, add_corner_portable<false>}}};
#else
constexpr Form<CornerKernels> forms_of_corners[] = {
    {InstructionSet::portable, {add_corner_portable<true>, add_corner_portable<false>}}};
#endif

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
      kernels_(best_of(corner_kernel_forms(), instruction_set())),
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
