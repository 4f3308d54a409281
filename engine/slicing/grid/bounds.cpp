#include "slicing/grid/bounds.hpp"

#include <string>

#include "base/words.hpp"
#include "lamella/grid.hpp"

namespace lamella {

namespace {

constexpr std::size_t grain = (1 << 12) / block_triangles;  // blocks per task

constexpr std::int64_t no_triangle_yet = std::numeric_limits<std::int64_t>::max();

/// The box of some blocks, whether all in it was finite, and the first triangle with an index that names no vertex.
struct Partial {
    Bounds box = Bounds::empty();
    bool finite = true;
    std::int64_t bad_index = no_triangle_yet;

    void add(const Partial& other) noexcept {
        box.add(other.box);
        finite = finite && other.finite;
        bad_index = std::min(bad_index, other.bad_index);
    }
};

/// True where two vertices of the triangle lie within `reach` of each other on every axis.
bool has_near_vertices(const RawTriangle& t, double reach) {
    const auto near = [&](const double* a, const double* b) {
        return std::abs(a[0] - b[0]) <= reach && std::abs(a[1] - b[1]) <= reach && std::abs(a[2] - b[2]) <= reach;
    };
    return near(t.v, t.v + 3) || near(t.v + 3, t.v + 6) || near(t.v + 6, t.v);
}

/// Blocks [begin, end) of any mesh.
Partial measure_general(const MeshView& mesh, const Placing& placing, std::size_t begin, std::size_t end,
                        BlockTable& table) {
    const PlacedReader read(mesh, placing);
    Partial all;
    double poison = 0;  // times zero: becomes NaN, and stays so, at the first value that is not finite
    for (std::size_t block = begin; block < end; ++block) {
        Bounds box = Bounds::empty();
        bool near = false;
        const std::size_t last = std::min(mesh.triangle_count, (block + 1) * block_triangles);
        for (std::size_t t = block * block_triangles; t < last; ++t) {
            const RawTriangle raw = read(t);
            for (int i = 0; i < 9; ++i) {
                box.add(i % 3, raw.v[i], raw.v[i]);
                poison += raw.v[i] * 0.0;
            }
            near = near || has_near_vertices(raw, table.near_mm);
        }
        table.blocks[block] = {box.min_mm[2], box.max_mm[2], near};
        all.box.add(box);
    }
    all.finite = poison == 0;
    return all;
}

#if defined(LAMELLA_SSE2)
#define LAMELLA_FOUR_FLOATS

/// Four floats, as every x86-64 has them.
struct Floats {
    using Vector = __m128;
    static Vector all_of(float value) noexcept { return _mm_set1_ps(value); }
    static Vector load(const float* at) noexcept { return _mm_loadu_ps(at); }
    static void store(float* at, Vector v) noexcept { _mm_storeu_ps(at, v); }
    /// `b` where that is NaN, or both are zeros.
    static Vector least(Vector a, Vector b) noexcept { return _mm_min_ps(a, b); }
    static Vector greatest(Vector a, Vector b) noexcept { return _mm_max_ps(a, b); }
    /// Lanes 1, 2 and 3, then another one.
    static Vector upper_three(Vector v) noexcept { return _mm_shuffle_ps(v, v, _MM_SHUFFLE(3, 3, 2, 1)); }
    static Vector distance(Vector a, Vector b) noexcept { return _mm_andnot_ps(_mm_set1_ps(-0.0F), _mm_sub_ps(a, b)); }
    /// True if the first three lanes of `a` are all at most those of `limit`.
    static bool three_within(Vector a, Vector limit) noexcept { return (_mm_movemask_ps(_mm_cmple_ps(a, limit)) & 7) == 7; }
    static Vector sum(Vector a, Vector b) noexcept { return _mm_add_ps(a, b); }
    static bool any_nan(Vector v) noexcept { return _mm_movemask_ps(_mm_cmpunord_ps(v, v)) != 0; }
};

#elif defined(LAMELLA_NEON_FORMS)
#define LAMELLA_FOUR_FLOATS

/// The same, as every ARM of 64 bits has them.
struct Floats {
    using Vector = float32x4_t;
    static Vector all_of(float value) noexcept { return vdupq_n_f32(value); }
    static Vector load(const float* at) noexcept { return vld1q_f32(at); }
    static void store(float* at, Vector v) noexcept { vst1q_f32(at, v); }
    static Vector least(Vector a, Vector b) noexcept { return vbslq_f32(vcltq_f32(a, b), a, b); }
    static Vector greatest(Vector a, Vector b) noexcept { return vbslq_f32(vcgtq_f32(a, b), a, b); }
    static Vector upper_three(Vector v) noexcept { return vextq_f32(v, v, 1); }
    static Vector distance(Vector a, Vector b) noexcept { return vabdq_f32(a, b); }
    static bool three_within(Vector a, Vector limit) noexcept {
        return vminvq_u32(vsetq_lane_u32(0xFFFFFFFF, vcleq_f32(a, limit), 3)) != 0;
    }
    static Vector sum(Vector a, Vector b) noexcept { return vaddq_f32(a, b); }
    static bool any_nan(Vector v) noexcept { return vminvq_u32(vceqq_f32(v, v)) == 0; }
};

#endif
#ifdef LAMELLA_FOUR_FLOATS

// A float soup without a transform: three vectors that cover a triangle and nothing beyond it. The last is turned by one
// lane, so that each begins with x, y and z of a vertex.
//
//     x0 y0 z0 x1 y1 z1 x2 y2 z2
//     [---a-----]
//              [---b-----]
//                    [---c-----]

/// The box of vertices, in the first three lanes.
struct SoupBox {
    Floats::Vector low = Floats::all_of(std::numeric_limits<float>::infinity());
    Floats::Vector high = Floats::all_of(-std::numeric_limits<float>::infinity());

    void add(Floats::Vector lower, Floats::Vector upper) noexcept {
        low = Floats::least(low, lower);
        high = Floats::greatest(high, upper);
    }
    Bounds by_axis() const noexcept {
        float lows[4];
        float highs[4];
        Floats::store(lows, low);
        Floats::store(highs, high);
        Bounds box = Bounds::empty();
        for (int axis = 0; axis < 3; ++axis) {
            box.add(axis, static_cast<double>(lows[axis]), static_cast<double>(highs[axis]));
        }
        return box;
    }
};

Partial measure_soup(const MeshView& mesh, std::size_t begin, std::size_t end, BlockTable& table) {
    const Floats::Vector reach = Floats::all_of(static_cast<float>(table.near_mm));
    const std::byte* const vertices = mesh.vertex_at(0);
    const std::size_t stride = mesh.vertex_step();
    SoupBox all;
    Floats::Vector sides = Floats::all_of(0);  // a sum: becomes NaN, and stays so, at the first coordinate that is
    for (std::size_t block = begin; block < end; ++block) {
        const std::size_t last = std::min(mesh.triangle_count, (block + 1) * block_triangles);
        SoupBox box;
        bool near = false;
        for (std::size_t t = block * block_triangles; t < last; ++t) {
            prefetch_ahead(vertices + t * stride, 1);
            const auto* at = reinterpret_cast<const float*>(vertices + t * stride);
            const Floats::Vector a = Floats::load(at);
            const Floats::Vector b = Floats::load(at + 3);
            const Floats::Vector c = Floats::upper_three(Floats::load(at + 5));
            const Floats::Vector low = Floats::least(a, b);
            const Floats::Vector high = Floats::greatest(a, b);
            box.add(Floats::least(low, c), Floats::greatest(high, c));
            const Floats::Vector ab = Floats::distance(a, b);
            const Floats::Vector bc = Floats::distance(b, c);
            const Floats::Vector ca = Floats::distance(c, a);
            sides = Floats::sum(sides, Floats::sum(bc, ca));
            // Most triangles have an axis on which no two vertices are near: one comparison then does for three.
            if (Floats::three_within(Floats::least(ab, Floats::least(bc, ca)), reach)) {
                near = near || Floats::three_within(ab, reach) || Floats::three_within(bc, reach) ||
                       Floats::three_within(ca, reach);
            }
        }
        const Bounds by_axis = box.by_axis();
        table.blocks[block] = {by_axis.min_mm[2], by_axis.max_mm[2], near};
        all.add(box.low, box.high);
    }
    Partial found;
    found.box = all.by_axis();
    found.finite = !Floats::any_nan(sides);  // infinity shows in the box
    return found;
}

#endif
#if defined(LAMELLA_FOUR_FLOATS) && defined(LAMELLA_X86_FORMS)
#define LAMELLA_FLOAT_PAIRS

/// The same, two triangles at a time, one in each half of a vector.
struct FloatPairs {
    LAMELLA_AVX2_INLINE static __m256 load(const float* first, const float* second) noexcept {
        return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(first)), _mm_loadu_ps(second), 1);
    }
    LAMELLA_AVX2_INLINE static __m256 distance(__m256 a, __m256 b) noexcept {
        return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), _mm256_sub_ps(a, b));
    }
    LAMELLA_AVX2_INLINE static __m256i within(__m256 distance, __m256 reach) noexcept {
        return _mm256_castps_si256(_mm256_cmp_ps(distance, reach, _CMP_LE_OQ));
    }
    /// Not 0 if the first three lanes of a half are all within `reach`. Each lane becomes a byte, of which a bit is read.
    LAMELLA_AVX2_INLINE static unsigned near(__m256 ab, __m256 bc, __m256 ca, __m256 reach) noexcept {
        const __m256i two = _mm256_packs_epi32(within(ab, reach), within(bc, reach));
        const __m256i third = _mm256_packs_epi32(within(ca, reach), _mm256_setzero_si256());
        const auto lanes = static_cast<unsigned>(_mm256_movemask_epi8(_mm256_packs_epi16(two, third)));
        return lanes & lanes >> 1 & lanes >> 2 & 0x0111'0111U;
    }
    LAMELLA_AVX2_INLINE static void add(SoupBox& box, __m256 low, __m256 high) noexcept {
        box.add(_mm256_castps256_ps128(low), _mm256_castps256_ps128(high));
        box.add(_mm256_extractf128_ps(low, 1), _mm256_extractf128_ps(high, 1));
    }
};

LAMELLA_AVX2 Partial measure_soup_avx2(const MeshView& mesh, std::size_t begin, std::size_t end, BlockTable& table) {
    const __m256 reach = _mm256_set1_ps(static_cast<float>(table.near_mm));
    const std::byte* const vertices = mesh.vertex_at(0);
    const std::size_t stride = mesh.vertex_step();
    SoupBox all;
    __m256 sides = _mm256_setzero_ps();
    for (std::size_t block = begin; block < end; ++block) {
        const std::size_t last = std::min(mesh.triangle_count, (block + 1) * block_triangles);
        __m256 low = _mm256_set1_ps(std::numeric_limits<float>::infinity());
        __m256 high = _mm256_set1_ps(-std::numeric_limits<float>::infinity());
        unsigned near = 0;
        for (std::size_t t = block * block_triangles; t < last; t += 2) {
            const std::byte* const at = vertices + t * stride;
            prefetch_ahead(at, 1);
            prefetch_ahead(at + stride, 1);
            const auto* first = reinterpret_cast<const float*>(at);
            const auto* second = reinterpret_cast<const float*>(t + 1 < last ? at + stride : at);
            const __m256 a = FloatPairs::load(first, second);
            const __m256 b = FloatPairs::load(first + 3, second + 3);
            const __m256 z1_c = FloatPairs::load(first + 5, second + 5);
            const __m256 c = _mm256_shuffle_ps(z1_c, z1_c, _MM_SHUFFLE(3, 3, 2, 1));
            low = _mm256_min_ps(low, _mm256_min_ps(_mm256_min_ps(a, b), c));
            high = _mm256_max_ps(high, _mm256_max_ps(_mm256_max_ps(a, b), c));
            const __m256 bc = FloatPairs::distance(b, c);
            const __m256 ca = FloatPairs::distance(c, a);
            sides = _mm256_add_ps(sides, _mm256_add_ps(bc, ca));
            near |= FloatPairs::near(FloatPairs::distance(a, b), bc, ca, reach);
        }
        SoupBox box;
        FloatPairs::add(box, low, high);
        const Bounds by_axis = box.by_axis();
        table.blocks[block] = {by_axis.min_mm[2], by_axis.max_mm[2], near != 0};
        all.add(box.low, box.high);
    }
    Partial found;
    found.box = all.by_axis();
    found.finite = _mm256_movemask_ps(_mm256_cmp_ps(sides, sides, _CMP_UNORD_Q)) == 0;
    return found;
}

#endif

/// Blocks [begin, end).
Partial measure_blocks(const MeshView& mesh, const Placing& placing, std::size_t begin, std::size_t end, BlockTable& table) {
    if (mesh.vertex_type != Number::f32 || mesh.indices != nullptr || !placing.transform.is_identity()) {
        return measure_general(mesh, placing, begin, end, table);
    }
#ifdef LAMELLA_FLOAT_PAIRS
    if (table.instructions >= InstructionSet::avx2) {
        return measure_soup_avx2(mesh, begin, end, table);
    }
#endif
#ifdef LAMELLA_FOUR_FLOATS
    return measure_soup(mesh, begin, end, table);
#else
    return measure_general(mesh, placing, begin, end, table);
#endif
}

std::string axis_text(int i) {
    return std::string("vertex ") + std::to_string(i / 3) + ", " + "xyz"[i % 3];
}

/// Finds the triangle with the bad coordinate. Serial: it runs once, on input that is refused.
Error first_bad_coordinate(const MeshView& mesh, const Placing& placing) {
    const PlacedReader read(mesh, placing);
    for (std::size_t t = 0; t < mesh.triangle_count; ++t) {
        const RawTriangle raw = read(t);
        for (int i = 0; i < 9; ++i) {
            if (!(std::abs(raw.v[i]) <= largest_coordinate_mm)) {
                const char* what = std::isfinite(raw.v[i]) ? " is beyond 1e9 mm" : " is not finite";
                return {ErrorCode::bad_coordinate, "triangle " + std::to_string(t) + ", " + axis_text(i) + what,
                        static_cast<std::int64_t>(t)};
            }
        }
    }
    return {ErrorCode::bad_coordinate, "a coordinate is not finite or beyond 1e9 mm"};
}

/// The first triangle with an index that names no vertex, or -1.
std::int64_t first_bad_index(const MeshView& mesh, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
        if (std::max({mesh.vertex_of(t, 0), mesh.vertex_of(t, 1), mesh.vertex_of(t, 2)}) >= mesh.vertex_count) {
            return static_cast<std::int64_t>(t);
        }
    }
    return -1;
}

template <class TooFine>
ChosenUnit doubled_while(double unit_mm, TooFine too_fine) {
    ChosenUnit unit{unit_mm, 0};
    for (; too_fine(unit.mm); ++unit.doublings) {
        unit.mm *= 2;
    }
    return unit;
}

Error no_triangles() {
    return {ErrorCode::empty_mesh, "the mesh has no triangles"};
}

}  // namespace

Result<Bounds> measure_bounds(const MeshView& mesh, const Placing& placing, double unit_mm, const Parallel& parallel,
                              BlockTable& table) {
    if (mesh.triangle_count == 0) {
        return no_triangles();
    }
    if (mesh.triangle_count >= std::numeric_limits<std::uint32_t>::max()) {
        return Error{ErrorCode::invalid_argument, "the mesh has more than 2^32 - 2 triangles"};
    }
    if (const Status status = check_mesh(mesh); !status) {
        return status.error();
    }
    if (const Status status = check_transform(placing.transform); !status) {
        return status.error();
    }
    table.near_mm = BlockTable::near_mm_for(unit_mm > 0 ? unit_mm : default_grid_mm);
    table.blocks.resize_discarding(block_count(mesh.triangle_count));
    PerWorker<Partial> partial(parallel.workers_for(table.blocks.size() / grain));
    parallel.run_ranges(table.blocks.size(), grain, [&](std::size_t begin, std::size_t end, int worker) {
        const auto w = static_cast<std::size_t>(worker);
        if (mesh.indices != nullptr) {
            const std::size_t last = std::min(mesh.triangle_count, end * block_triangles);
            if (const std::int64_t bad = first_bad_index(mesh, begin * block_triangles, last); bad >= 0) {
                partial[w].bad_index = std::min(partial[w].bad_index, bad);
                return;
            }
        }
        partial[w].add(measure_blocks(mesh, placing, begin, end, table));
    });
    Partial all;
    partial.for_each([&all](const Partial& p) { all.add(p); });
    if (all.bad_index != no_triangle_yet) {
        return Error{ErrorCode::invalid_argument,
                     "triangle " + std::to_string(all.bad_index) + " has an index beyond the last vertex", all.bad_index};
    }
    if (!all.finite || !(all.box.farthest() <= largest_coordinate_mm)) {
        return first_bad_coordinate(mesh, placing);
    }
    return all.box;
}

Status check_mesh(const MeshView& mesh) {
    if (mesh.vertices == nullptr && (mesh.indices == nullptr ? mesh.triangle_count : mesh.vertex_count) != 0) {
        return Error{ErrorCode::invalid_argument, "the mesh has no vertices: null"};
    }
    if (mesh.vertex_type > Number::i64) {
        return Error{ErrorCode::invalid_argument, "vertices are of f32, f64, i32 or i64"};
    }
    if (mesh.indices != nullptr && mesh.index_type != Number::u32 && mesh.index_type != Number::u64) {
        return Error{ErrorCode::invalid_argument, "indices are of u32 or u64"};
    }
    if (!(mesh.mm_per_unit > 0) || !std::isfinite(mesh.mm_per_unit)) {
        return Error{ErrorCode::invalid_argument, "mm_per_unit must be finite and above 0"};
    }
    return {};
}

Status check_transform(const Transform& transform) {
    if (transform.is_singular()) {
        return Error{ErrorCode::invalid_argument,
                     "the transform is singular: its determinant is 0, so that it flattens every mesh"};
    }
    return {};
}

double finest_unit(double farthest_mm) noexcept {
    double unit = 0x1p-49;
    while (farthest_mm > unit * (grid_limit - 2)) {
        unit *= 2;
    }
    return unit;
}

Result<ChosenUnit> choose_unit(const Bounds& bounds, double asked_mm, bool coarser, double reach_mm) {
    const double largest = bounds.farthest();
    if (asked_mm == 0) {
        return doubled_while(default_grid_mm, [&](double unit) { return largest > unit * grid_limit; });
    }
    const double farthest = std::max(largest, bounds.farthest_in_plane() + reach_mm);
    if (asked_mm == finest_grid) {
        return ChosenUnit{finest_unit(farthest), 0};
    }
    if (!(asked_mm > 0) || !(asked_mm <= largest_coordinate_mm) || asked_mm < 1e-15) {
        return Error{ErrorCode::invalid_argument, "the grid unit must be between 1e-15 and 1e9 mm"};
    }
    // Rounding moves a vertex by up to a unit; the limit keeps two of room.
    const auto too_fine = [](double reaching, double unit) { return reaching / unit > grid_limit - 2; };
    if (coarser) {
        return doubled_while(asked_mm, [&](double unit) { return too_fine(farthest, unit); });
    }
    if (too_fine(largest, asked_mm)) {
        return Error{ErrorCode::bad_coordinate, "the mesh reaches " + exact_text(largest) + " mm, which a grid unit of " +
                                                    exact_text(asked_mm) + " mm cannot hold in 32 bits"};
    }
    return ChosenUnit{asked_mm, 0};
}

Error all_collapsed(std::size_t triangles, double unit_mm) {
    if (triangles == 0) {
        return no_triangles();
    }
    return {ErrorCode::empty_mesh,
            (triangles == 1 ? "the triangle has" : "each of " + counted(triangles, "triangle") + " has") +
                std::string(" two equal corners on the grid of ") + exact_text(unit_mm) + " mm"};
}

}  // namespace lamella
