#include "4_bucket/z_scan.hpp"

#include <cmath>

#if defined(__x86_64__) && defined(__GNUC__)
#define LAMELLA_X86_KERNELS
#include <immintrin.h>
#define LAMELLA_AVX512 __attribute__((target("avx512f,avx512vl,avx2")))
#endif

namespace lamella {

namespace {

/// A guessed plane is off by one at most as long as floats tell planes apart, and rounding moves none by a step.
constexpr PlaneIndex most_planes = 1 << 19;
constexpr double least_step_units = 256;

}  // namespace

#ifdef LAMELLA_X86_KERNELS

ZScan::ZScan(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes) noexcept
    : vertices_(mesh.vertices),
      stride_(static_cast<std::int32_t>(mesh.stride)),
      scale_(static_cast<float>(1 / (2 * unit_mm))),
      planes_(planes.size() > 0 ? planes.heights() : nullptr) {
    int exponent = 0;
    usable_ = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && mesh.number == Number::f32 &&
              mesh.indices == nullptr && mesh.stride < (1U << 20) && transform.is_identity() &&
              std::frexp(unit_mm, &exponent) == 0.5 && planes.uniform() && planes.size() > 0 &&
              planes.size() <= most_planes && planes.planes_per_unit() * least_step_units <= 1;
    if (usable_) {
        first_z_ = static_cast<float>(planes.z(0));
        planes_per_unit_ = static_cast<float>(planes.planes_per_unit());
        last_plane_ = static_cast<std::int32_t>(planes.size());
    }
}

namespace {

LAMELLA_AVX512 __m512i to_grid(__m512 mm, __m512 scale) {
    const __m512i half = _mm512_maskz_cvtps_epi32(0xFFFF, _mm512_mul_ps(mm, scale));
    return _mm512_add_epi32(half, half);
}

LAMELLA_AVX512 __m512 gather(const std::byte* at, __m512i offsets) {
    return _mm512_mask_i32gather_ps(_mm512_setzero_ps(), 0xFFFF, offsets, reinterpret_cast<const float*>(at), 1);
}

}  // namespace

LAMELLA_AVX512 void ZScan::operator()(std::size_t begin, ZBlock& block) const noexcept {
    constexpr std::size_t z_offset = 2 * sizeof(float);
    const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i offsets = _mm512_maskz_mullo_epi32(0xFFFF, lanes, _mm512_set1_epi32(stride_));
    const __m512 scale = _mm512_set1_ps(scale_);
    const auto stride = static_cast<std::size_t>(stride_);
    block.crossed = 0;
    block.level_edge = 0;
    for (std::size_t group = 0; group < 64; group += 16) {
        const std::byte* at = vertices_ + (begin + group) * stride + z_offset;
        const __m512i z0 = to_grid(gather(at, offsets), scale);
        const __m512i z1 = to_grid(gather(at + 3 * sizeof(float), offsets), scale);
        const __m512i z2 = to_grid(gather(at + 6 * sizeof(float), offsets), scale);
        const auto level = static_cast<std::uint64_t>(_mm512_cmpeq_epi32_mask(z0, z1) | _mm512_cmpeq_epi32_mask(z1, z2) |
                                                      _mm512_cmpeq_epi32_mask(z2, z0));
        const __m512i low = _mm512_maskz_min_epi32(0xFFFF, z0, _mm512_maskz_min_epi32(0xFFFF, z1, z2));
        const __m512i high = _mm512_maskz_max_epi32(0xFFFF, z0, _mm512_maskz_max_epi32(0xFFFF, z1, z2));
        // The guess g, rounded down, and up to three planes from g - 1 on that may still lie below: their number is added.
        const __m512 guess = _mm512_mul_ps(_mm512_sub_ps(_mm512_maskz_cvtepi32_ps(0xFFFF, low), _mm512_set1_ps(first_z_)),
                                           _mm512_set1_ps(planes_per_unit_));
        const __m512i last = _mm512_set1_epi32(last_plane_);
        const __m512i from = _mm512_maskz_max_epi32(
            0xFFFF, _mm512_setzero_si512(),
            _mm512_maskz_min_epi32(0xFFFF, last,
                                   _mm512_sub_epi32(_mm512_maskz_cvttps_epi32(0xFFFF, guess), _mm512_set1_epi32(1))));
        __m512i first = from;
        for (int step = 0; step < 4; ++step) {
            const __m512i plane = _mm512_mask_i32gather_epi32(last, 0xFFFF, first, planes_, 4);
            first = _mm512_mask_add_epi32(first, _mm512_cmpgt_epi32_mask(low, plane), first, _mm512_set1_epi32(1));
        }
        const __m512i plane = _mm512_mask_i32gather_epi32(last, 0xFFFF, first, planes_, 4);
        const auto crossed = static_cast<std::uint64_t>(_mm512_cmpgt_epi32_mask(high, plane));
        _mm512_storeu_si512(block.low + group, low);
        _mm512_storeu_si512(block.high + group, high);
        _mm512_storeu_si512(block.first + group, first);
        block.crossed |= crossed << group;
        block.level_edge |= level << group;
    }
}

#else

ZScan::ZScan(const MeshView& mesh, const Transform&, double, const PlaneSet&) noexcept
    : vertices_(mesh.vertices), stride_(0), scale_(0), planes_(nullptr) {}

void ZScan::operator()(std::size_t, ZBlock&) const noexcept {}

#endif

}  // namespace lamella
