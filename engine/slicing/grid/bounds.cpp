#include "slicing/grid/bounds.hpp"

#include <string>

#include "base/dispatch.hpp"
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
    using Lanes = __m128;
    static Vector all_of(float value) noexcept { return _mm_set1_ps(value); }
    static Vector load(const float* at) noexcept { return _mm_loadu_ps(at); }
    static void store(float* at, Vector v) noexcept { _mm_storeu_ps(at, v); }
    /// `b` where that is NaN, or both are zeros.
    static Vector least(Vector a, Vector b) noexcept { return _mm_min_ps(a, b); }
    static Vector greatest(Vector a, Vector b) noexcept { return _mm_max_ps(a, b); }
    /// Lanes 1, 2 and 3, then another one.
    static Vector upper_three(Vector v) noexcept { return _mm_shuffle_ps(v, v, _MM_SHUFFLE(3, 3, 2, 1)); }
    /// True if the first three lanes are all within `reach` of each other.
    static bool are_near(Vector a, Vector b, Vector reach) noexcept {
        const Vector size = _mm_andnot_ps(_mm_set1_ps(-0.0F), _mm_sub_ps(a, b));
        return (_mm_movemask_ps(_mm_cmple_ps(size, reach)) & 7) == 7;
    }
    /// Sets the lanes of `nan` where one of the two is NaN.
    static void add_nan(Lanes& nan, Vector a, Vector b) noexcept { nan = _mm_or_ps(nan, _mm_cmpunord_ps(a, b)); }
    static bool any(Lanes lanes) noexcept { return _mm_movemask_ps(lanes) != 0; }
};

#elif defined(LAMELLA_NEON_FORMS)
#define LAMELLA_FOUR_FLOATS

/// The same, as every ARM of 64 bits has them.
struct Floats {
    using Vector = float32x4_t;
    using Lanes = uint32x4_t;
    static Vector all_of(float value) noexcept { return vdupq_n_f32(value); }
    static Vector load(const float* at) noexcept { return vld1q_f32(at); }
    static void store(float* at, Vector v) noexcept { vst1q_f32(at, v); }
    static Vector least(Vector a, Vector b) noexcept { return vbslq_f32(vcltq_f32(a, b), a, b); }
    static Vector greatest(Vector a, Vector b) noexcept { return vbslq_f32(vcgtq_f32(a, b), a, b); }
    static Vector upper_three(Vector v) noexcept { return vextq_f32(v, v, 1); }
    static bool are_near(Vector a, Vector b, Vector reach) noexcept {
        return vminvq_u32(vsetq_lane_u32(0xFFFFFFFF, vcaleq_f32(vsubq_f32(a, b), reach), 3)) != 0;
    }
    static void add_nan(Lanes& nan, Vector a, Vector b) noexcept {
        nan = vornq_u32(nan, vandq_u32(vceqq_f32(a, a), vceqq_f32(b, b)));
    }
    static bool any(Lanes lanes) noexcept { return vmaxvq_u32(lanes) != 0; }
};

#endif
#ifdef LAMELLA_FOUR_FLOATS

// A float soup without a transform: three vectors that cover a triangle and nothing beyond it.
//
//     x0 y0 z0 x1 y1 z1 x2 y2 z2
//     [---a-----]
//              [---b-----]
//                    [---c-----]

constexpr int offsets[3] = {0, 3, 5};

/// A box of each of the nine numbers of a triangle.
struct SoupBox {
    Floats::Vector low[3];
    Floats::Vector high[3];

    SoupBox() noexcept {
        for (int v = 0; v < 3; ++v) {
            low[v] = Floats::all_of(std::numeric_limits<float>::infinity());
            high[v] = Floats::all_of(-std::numeric_limits<float>::infinity());
        }
    }
    void add(int v, Floats::Vector lower, Floats::Vector upper) noexcept {
        low[v] = Floats::least(low[v], lower);
        high[v] = Floats::greatest(high[v], upper);
    }
    Bounds by_axis() const noexcept {
        float low9[9];
        float high9[9];
        for (int v = 0; v < 3; ++v) {
            Floats::store(low9 + offsets[v], low[v]);
            Floats::store(high9 + offsets[v], high[v]);
        }
        Bounds box = Bounds::empty();
        for (int i = 0; i < 9; ++i) {
            box.add(i % 3, static_cast<double>(low9[i]), static_cast<double>(high9[i]));
        }
        return box;
    }
};

Partial measure_soup(const MeshView& mesh, std::size_t begin, std::size_t end, BlockTable& table) {
    const Floats::Vector reach = Floats::all_of(static_cast<float>(table.near_mm));
    const std::byte* const vertices = mesh.vertex_at(0);
    const std::size_t stride = mesh.vertex_step();
    SoupBox all;
    Floats::Lanes nan{};
    for (std::size_t block = begin; block < end; ++block) {
        const std::size_t last = std::min(mesh.triangle_count, (block + 1) * block_triangles);
        SoupBox box;
        bool near = false;
        for (std::size_t t = block * block_triangles; t < last; ++t) {
            prefetch_ahead(vertices + t * stride, 1);
            const auto* at = reinterpret_cast<const float*>(vertices + t * stride);
            Floats::Vector value[3];
            for (int v = 0; v < 3; ++v) {
                value[v] = Floats::load(at + offsets[v]);
                box.add(v, value[v], value[v]);
            }
            const Floats::Vector third = Floats::upper_three(value[2]);
            near |= Floats::are_near(value[0], value[1], reach);
            near |= Floats::are_near(value[1], third, reach);
            near |= Floats::are_near(third, value[0], reach);
            Floats::add_nan(nan, value[0], value[1]);
            Floats::add_nan(nan, value[2], value[2]);
        }
        const Bounds by_axis = box.by_axis();
        table.blocks[block] = {by_axis.min_mm[2], by_axis.max_mm[2], near};
        for (int v = 0; v < 3; ++v) {
            all.add(v, box.low[v], box.high[v]);
        }
    }
    Partial found;
    found.box = all.by_axis();
    found.finite = !Floats::any(nan);  // infinity shows in the box
    return found;
}

#endif

/// Blocks [begin, end).
Partial measure_blocks(const MeshView& mesh, const Placing& placing, std::size_t begin, std::size_t end, BlockTable& table) {
#ifdef LAMELLA_FOUR_FLOATS
    if (mesh.vertex_type == Number::f32 && mesh.indices == nullptr && placing.transform.is_identity()) {
        return measure_soup(mesh, begin, end, table);
    }
#endif
    return measure_general(mesh, placing, begin, end, table);
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
