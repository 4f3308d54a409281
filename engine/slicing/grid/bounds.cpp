#include "slicing/grid/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "base/dispatch.hpp"
#include "base/parallel.hpp"
#include "base/words.hpp"
#include "lamella/grid.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

constexpr std::size_t grain = (1 << 12) / block_triangles;  // blocks per task

/// The box of some blocks, whether all in it was finite, and whether every index names a vertex.
struct Partial {
    Bounds box = Bounds::empty();
    bool finite = true;
    bool has_vertices = true;

    void add(const Partial& other) noexcept {
        box.add(other.box);
        finite = finite && other.finite;
        has_vertices = has_vertices && other.has_vertices;
    }
};

/// A corner of a triangle in vectors of the mesh's own numbers: x, y, z and a lane that nothing looks at.
template <class Vector, std::size_t vectors>
struct Corner {
    static constexpr std::size_t lanes = 4 / vectors;

    Vector part[vectors];

    double operator[](std::size_t axis) const noexcept { return part[axis / lanes][axis % lanes]; }

    /// True if all three lie within `reach` of each other's.
    bool is_near(const Corner& other, double reach) const noexcept {
        return std::abs((*this)[0] - other[0]) <= reach && std::abs((*this)[1] - other[1]) <= reach &&
               std::abs((*this)[2] - other[2]) <= reach;
    }
};

/// Blocks [begin, end) of `triangles` triangles, of which read(t, i) gives corner i.
template <class Vector, std::size_t vectors, class Read>
Partial measure_blocks(const Read& read, std::size_t triangles, std::size_t begin, std::size_t end, BlockTable& table) {
    using Vertex = Corner<Vector, vectors>;
    Partial all;
    Vertex poison{};  // becomes NaN, and stays so, at the first value that is not finite
    for (std::size_t block = begin; block < end; ++block) {
        Vertex low;
        Vertex high;
        std::fill_n(low.part, vectors, Vector{} + std::numeric_limits<float>::infinity());
        std::fill_n(high.part, vectors, Vector{} - std::numeric_limits<float>::infinity());
        bool near = false;
        const std::size_t last = std::min(triangles, (block + 1) * block_triangles);
        for (std::size_t t = block * block_triangles; t < last; ++t) {
            const Vertex v[3] = {read(t, 0), read(t, 1), read(t, 2)};
            for (std::size_t i = 0; i < vectors; ++i) {
                for (const Vertex& vertex : v) {
                    low.part[i] = vertex.part[i] < low.part[i] ? vertex.part[i] : low.part[i];
                    high.part[i] = vertex.part[i] > high.part[i] ? vertex.part[i] : high.part[i];
                }
                poison.part[i] += (v[0].part[i] + v[1].part[i] + v[2].part[i]) * Vector{};
            }
            near = near || v[0].is_near(v[1], table.near_mm) || v[1].is_near(v[2], table.near_mm) ||
                   v[2].is_near(v[0], table.near_mm);
        }
        table.blocks[block] = {low[2], high[2], near};
        all.box.add({{low[0], low[1], low[2]}, {high[0], high[1], high[2]}});
    }
    all.finite = poison[0] == 0 && poison[1] == 0 && poison[2] == 0;
    return all;
}

/// Float soups without a transform are measured in floats, which is faster.
Partial measure_blocks(const MeshView& mesh, const Placing& placing, std::size_t begin, std::size_t end, BlockTable& table) {
    if (mesh.vertex_type == Number::f32 && mesh.indices == nullptr && placing.transform.is_identity()) {
        const auto read = [at = mesh.vertex_at(0), step = mesh.vertex_step()](std::size_t t, std::size_t corner) {
            prefetch_ahead(at + t * step, 1);
            float xyz[3];
            std::memcpy(xyz, at + t * step + corner * sizeof xyz, sizeof xyz);
            return Corner<FourFloats, 1>{{FourFloats{xyz[0], xyz[1], xyz[2], 0}}};
        };
        return measure_blocks<FourFloats, 1>(read, mesh.triangle_count, begin, end, table);
    }
    const auto read = [placed = PlacedReader(mesh, placing)](std::size_t t, std::size_t corner) {
        const auto [xy, z] = placed.vertex(t, corner);
        return Corner<TwoDoubles, 2>{{xy, z}};
    };
    return measure_blocks<TwoDoubles, 2>(read, mesh.triangle_count, begin, end, table);
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
        const std::size_t last = std::min(mesh.triangle_count, end * block_triangles);
        if (mesh.indices != nullptr && first_bad_index(mesh, begin * block_triangles, last) >= 0) {
            partial[w].has_vertices = false;
            return;
        }
        partial[w].add(measure_blocks(mesh, placing, begin, end, table));
    });
    Partial all;
    partial.for_each([&all](const Partial& p) { all.add(p); });
    if (!all.has_vertices) {
        const std::int64_t bad = first_bad_index(mesh, 0, mesh.triangle_count);
        return Error{ErrorCode::invalid_argument, "triangle " + std::to_string(bad) + " has an index beyond the last vertex",
                     bad};
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
