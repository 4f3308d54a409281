#include "slicing/buckets/mesh_source.hpp"

#include <array>
#include <cmath>

#include "base/dispatch.hpp"
#include "base/system/processor.hpp"

namespace lamella {

namespace {

/// Float arithmetic finds a plane to within one, if floats resolve planes and rounding of heights (to 24 bits, then to the
/// grid) moves none by much of a step.
constexpr PlaneIndex most_by_arithmetic = 1 << 19;
constexpr double least_step_units = 1024;
constexpr PlaneIndex most_scanned_planes = 1 << 28;  // indices of gathers are signed, and the table has two cells a plane

}  // namespace

SoupScan::SoupScan(const MeshView& mesh, const Placing& placing, double unit_mm, const PlaneSet& planes,
                   InstructionSet instructions) noexcept
    : vertices_(mesh.vertex_at(0)),
      stride_(static_cast<std::int32_t>(mesh.vertex_step())),
      scale_(static_cast<float>(1 / (2 * unit_mm))),
      planes_(planes) {
    int exponent = 0;
    const bool allowed = mesh.vertex_type == Number::f32 && mesh.indices == nullptr && mesh.vertex_step() < (1U << 20) &&
                         placing.transform.is_identity() && std::frexp(unit_mm, &exponent) == 0.5 && planes.size() > 0 &&
                         planes.size() <= most_scanned_planes;
    kernels_ = allowed ? kernels(instructions) : nullptr;
    if (planes.uniform() && planes.size() <= most_by_arithmetic && planes.planes_per_unit() * least_step_units <= 1) {
        planes_per_unit_ = static_cast<float>(planes.planes_per_unit());
    }
}

#ifdef LAMELLA_X86_FORMS

namespace {

constexpr int table_steps = 4;     // planes of a cell compared before the rest of it is searched
constexpr __mmask16 nine = 0x1FF;  // numbers of a triangle

}  // namespace

/// The code that needs AVX-512.
struct SoupKernel {
    struct Heights {
        __m512i z[3];
    };

    /// Numbers at `at` and all_lanes stride from there on.
    LAMELLA_AVX512 static __m512i gather_grid(const SoupScan& scan, const std::byte* at, __m512i offsets) {
        const __m512 mm =
            _mm512_mask_i32gather_ps(_mm512_setzero_ps(), all_lanes, offsets, reinterpret_cast<const float*>(at), 1);
        return round_even(mm, _mm512_set1_ps(scan.scale_));
    }

    LAMELLA_AVX512 static __m512i round_even(__m512 mm, __m512 scale) {
        const __m512i half = _mm512_maskz_cvtps_epi32(all_lanes, _mm512_mul_ps(mm, scale));
        return _mm512_add_epi32(half, half);
    }

    /// z of triangles [begin, begin + 16).
    LAMELLA_AVX512 static Heights heights(const SoupScan& scan, std::size_t begin) {
        const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
        const __m512i offsets = _mm512_mullo_epi32(lanes, _mm512_set1_epi32(scan.stride_));
        const auto stride = static_cast<std::size_t>(scan.stride_);
        const std::byte* at = scan.vertices_ + begin * stride + 2 * sizeof(float);
        prefetch_ahead(at, lanes_of_512 * stride);
        return {{gather_grid(scan, at, offsets), gather_grid(scan, at + 3 * sizeof(float), offsets),
                 gather_grid(scan, at + 6 * sizeof(float), offsets)}};
    }

    LAMELLA_AVX512 static __m512i least(__m512i a, __m512i b) { return _mm512_maskz_min_epi32(all_lanes, a, b); }
    LAMELLA_AVX512 static __m512i greatest(__m512i a, __m512i b) { return _mm512_maskz_max_epi32(all_lanes, a, b); }

    LAMELLA_AVX512 static __m512i gather(const void* table, __m512i index) {
        return _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), all_lanes, index, table, 4);
    }

    /// The first plane above each height.
    LAMELLA_AVX512 static __m512i first_above(const SoupScan& scan, __m512i z) {
        return scan.planes_per_unit_ > 0 ? by_arithmetic(scan, z) : by_table(scan, z);
    }

    /// At x steps above plane 0, the answer is plane floor(x - 1/4) + 1 or the next: a quarter step covers all rounding.
    LAMELLA_AVX512 static __m512i by_arithmetic(const SoupScan& scan, __m512i z) {
        const std::int32_t* planes = scan.planes_.heights();
        const __m512 rise = _mm512_maskz_cvtepi32_ps(all_lanes, _mm512_sub_epi32(z, _mm512_set1_epi32(planes[0])));
        const __m512 steps = _mm512_mul_ps(rise, _mm512_set1_ps(scan.planes_per_unit_));
        const __m512i guess = _mm512_maskz_cvt_roundps_epi32(all_lanes, _mm512_add_ps(steps, _mm512_set1_ps(0.75F)),
                                                             _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
        const __m512i end = _mm512_set1_epi32(static_cast<std::int32_t>(scan.planes_.size()));
        const __m512i first = greatest(_mm512_setzero_si512(), least(end, guess));
        const __mmask16 below = _mm512_cmpgt_epi32_mask(z, gather(planes, first));
        return _mm512_mask_add_epi32(first, below, first, _mm512_set1_epi32(1));
    }

    LAMELLA_AVX512 static __m512i by_table(const SoupScan& scan, __m512i z) {
        const HeightTable& table = scan.planes_.table();
        const __m512i lowest = _mm512_set1_epi32(table.lowest);
        const __m512i clamped = least(_mm512_set1_epi32(table.highest), greatest(lowest, z));
        const __m512i cell =
            _mm512_maskz_srl_epi32(all_lanes, _mm512_sub_epi32(clamped, lowest), _mm_cvtsi32_si128(table.shift));
        __m512i first = gather(table.first.data(), cell);
        __mmask16 below = all_lanes;
        for (int step = 0; step < table_steps && below != 0; ++step) {
            below = _mm512_cmpgt_epi32_mask(z, gather(scan.planes_.heights(), first));
            first = _mm512_mask_add_epi32(first, below, first, _mm512_set1_epi32(1));
        }
        return below == 0 ? first : search(scan, z, first, below);
    }

    /// For lanes whose cell holds more planes than table_steps.
    LAMELLA_AVX512 __attribute__((noinline)) static __m512i search(const SoupScan& scan, __m512i z, __m512i first,
                                                                   unsigned lanes) {
        alignas(64) std::int32_t heights[lanes_of_512];
        alignas(64) PlaneIndex found[lanes_of_512];
        _mm512_store_si512(heights, z);
        _mm512_store_si512(found, first);
        for (; lanes != 0; lanes &= lanes - 1) {
            const int lane = __builtin_ctz(lanes);
            found[lane] = scan.planes_.by_table(heights[lane]);
        }
        return _mm512_load_si512(found);
    }

    LAMELLA_AVX512 static std::uint64_t ranges(const SoupScan& scan, std::size_t begin, SoupScan::Ranges& ranges) {
        std::uint64_t crossed = 0;
        for (std::size_t group = 0; group < block_triangles; group += lanes_of_512) {
            const auto [z] = heights(scan, begin + group);
            const __m512i first = first_above(scan, least(z[0], least(z[1], z[2])));
            const __m512i last = first_above(scan, greatest(z[0], greatest(z[1], z[2])));
            _mm512_storeu_si512(ranges.first + group, first);
            _mm512_storeu_si512(ranges.last + group, last);
            crossed |= static_cast<std::uint64_t>(_mm512_cmplt_epi32_mask(first, last)) << group;
        }
        return crossed;
    }

    /// For each order of heights, the number of a triangle that each number of its record is.
    using Lanes = std::array<std::array<std::int32_t, 16>, 8>;
    static constexpr Lanes make_lanes() {
        Lanes lanes{};
        for (std::size_t order = 0; order < 8; ++order) {
            const HeightOrder& from = height_orders[order];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                lanes[order][axis] = static_cast<std::int32_t>(3U * from.lower + axis);
                lanes[order][3 + axis] = static_cast<std::int32_t>(3U * from.middle + axis);
                lanes[order][6 + axis] = static_cast<std::int32_t>(3U * from.upper + axis);
            }
        }
        return lanes;
    }
    static constexpr unsigned even_orders() {
        unsigned even = 0;
        for (unsigned order = 0; order < 8; ++order) {
            even |= (height_orders[order].odd == 0 ? 1U : 0U) << order;
        }
        return even;
    }

    /// Sixteen triangles before their records are written.
    struct alignas(64) Group {
        std::uint32_t order[lanes_of_512];
        std::uint32_t middle_and_source[lanes_of_512];
    };
    struct Planes {
        __m512i first, last;
    };

    LAMELLA_AVX512 static Planes order_group(const SoupScan& scan, std::size_t begin, Group& group) {
        const auto [z] = heights(scan, begin);
        const __m512i order =
            _mm512_or_epi32(_mm512_maskz_set1_epi32(_mm512_cmplt_epi32_mask(z[1], z[0]), 1),
                            _mm512_or_epi32(_mm512_maskz_set1_epi32(_mm512_cmplt_epi32_mask(z[2], z[1]), 2),
                                            _mm512_maskz_set1_epi32(_mm512_cmplt_epi32_mask(z[2], z[0]), 4)));
        const __m512i low = least(z[0], z[1]);
        const __m512i high = greatest(z[0], z[1]);
        const __m512i first = first_above(scan, least(low, z[2]));
        const __m512i middle = first_above(scan, greatest(low, least(high, z[2])));
        const __m512i last = first_above(scan, greatest(high, z[2]));
        // The long edge is the source where bit `order` of the even orders is set.
        constexpr auto even = static_cast<std::int32_t>(even_orders());
        const __m512i is_source =
            _mm512_maskz_slli_epi32(all_lanes, _mm512_maskz_srlv_epi32(all_lanes, _mm512_set1_epi32(even), order), 31);
        _mm512_store_si512(group.order, order);
        _mm512_store_si512(group.middle_and_source, _mm512_or_epi32(middle, is_source));
        return {first, last};
    }

    /// Triangle t's vertices, in the order of height.
    LAMELLA_AVX512 static void write_vertices(const SoupScan& scan, std::size_t t, std::uint32_t order,
                                              CrossedTriangle& record) {
        static constexpr Lanes lanes = make_lanes();
        const __m512 mm = _mm512_maskz_loadu_ps(nine, scan.vertices_ + t * static_cast<std::size_t>(scan.stride_));
        const __m512i from = _mm512_loadu_si512(lanes[order].data());
        const __m512i grid = round_even(mm, _mm512_set1_ps(scan.scale_));
        _mm512_mask_storeu_epi32(&record, nine, _mm512_maskz_permutexvar_epi32(all_lanes, from, grid));
    }

    /// The record of each triangle begin + t with bit t in `wanted` that planes of the tier cut: place(t, lowest corner, its
    /// planes) says where it goes, with the number that it gets.
    template <class Place>
    LAMELLA_AVX512 static void write_each(const SoupScan& scan, std::size_t begin, std::uint64_t wanted, PlaneRange tier,
                                          Place place) {
        const __m512i tier_first = _mm512_set1_epi32(static_cast<std::int32_t>(tier.first));
        const __m512i tier_end = _mm512_set1_epi32(static_cast<std::int32_t>(tier.end));
        for (std::size_t base = begin; wanted != 0; base += lanes_of_512, wanted >>= lanes_of_512) {
            if ((wanted & 0xFFFFU) == 0) {
                continue;
            }
            Group group;
            alignas(64) PlaneIndex first[lanes_of_512];
            alignas(64) PlaneIndex last[lanes_of_512];
            const Planes planes = order_group(scan, base, group);
            _mm512_store_si512(first, planes.first);
            _mm512_store_si512(last, planes.last);
            unsigned bits = _mm512_cmplt_epi32_mask(greatest(planes.first, tier_first), least(planes.last, tier_end));
            for (bits &= static_cast<unsigned>(wanted) & 0xFFFFU; bits != 0; bits &= bits - 1) {
                const auto lane = static_cast<std::size_t>(__builtin_ctz(bits));
                const std::uint32_t order = group.order[lane];
                CrossedTriangle& record =
                    place(base + lane, height_orders[order].lower, PlaneRange{first[lane], last[lane]});
                write_vertices(scan, base + lane, order, record);
                record.middle_and_source = group.middle_and_source[lane];
                record.last = last[lane];
            }
        }
    }

    LAMELLA_AVX512 static void write(const SoupScan& scan, std::size_t begin, std::uint64_t crossed, ShareRecords& to) {
        const auto place = [&to](std::size_t t, std::uint8_t lowest, PlaneRange cut) -> CrossedTriangle& {
            const std::uint32_t at = to.take_place(cut);
            CrossedTriangle& record = to.records[at];
            prefetch_to_write(&record + 2);  // of the same list, and likely the next to be written
            record.triangle = static_cast<std::uint32_t>(t);
            if (to.lowest_corners != nullptr) {
                to.lowest_corners[at] = lowest;
            }
            return record;
        };
        write_each(scan, begin, crossed, to.tier, place);
    }

    LAMELLA_AVX512 static std::size_t append(const SoupScan& scan, std::size_t begin, std::uint64_t wanted,
                                             CrossedTriangle* records) {
        CrossedTriangle* next = records;
        const auto place = [&next](std::size_t, std::uint8_t, PlaneRange cut) -> CrossedTriangle& {
            next->first = cut.first;
            return *next++;
        };
        write_each(scan, begin, wanted, {0, scan.planes_.size()}, place);
        return static_cast<std::size_t>(next - records);
    }
};

#endif

/// Null: one triangle at a time is the portable form.
const SoupScan::Kernels* SoupScan::kernels(InstructionSet instructions) noexcept {
#ifdef LAMELLA_X86_FORMS
    static constexpr Kernels avx512{SoupKernel::ranges, SoupKernel::write, SoupKernel::append};
#endif
    static constexpr Form<const Kernels*> forms[] = {
#ifdef LAMELLA_X86_FORMS
        {InstructionSet::avx512, &avx512},
#endif
        {InstructionSet::portable, nullptr}};
    return best_of<const Kernels*>(forms, instructions);
}

}  // namespace lamella
