#include "mesh/check/grid_mesh.hpp"

#include <cassert>
#include <iterator>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

#include "base/distribute.hpp"
#include "base/numbers.hpp"
#include "base/sort.hpp"
#include "mesh/vertex_numbers.hpp"
#include "slicing/grid/mesh_edge.hpp"

namespace lamella {

namespace {

/// Reads vertices on the grid, each with a hash of its coordinates as they are: that the only difference is missed has a
/// chance of 2^-32.
template <class Reader>
struct GridCorners {
    struct Vertex {
        GridVertex place;
        std::uint32_t exact;
        friend bool operator==(const Vertex& a, const Vertex& b) noexcept { return a.place == b.place; }
        friend bool operator<(const Vertex& a, const Vertex& b) noexcept { return a.place < b.place; }
    };

    const Reader& rounded;
    PlacedReader as_it_is;
    MortonOrder order;

    std::array<Vertex, 3> operator()(std::size_t t) const noexcept {
        const GridTriangle places = rounded(t);
        const RawTriangle raw = as_it_is(t);
        std::array<Vertex, 3> corners;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            corners[i] = {places[i], exact_hash(raw.v + 3 * i)};
        }
        return corners;
    }
    static std::uint64_t hash(const Vertex& vertex) noexcept { return hash_of(vertex.place); }
    std::uint64_t key(const Vertex& vertex) const noexcept { return order.key(vertex.place); }
    static bool differ(const Vertex& a, const Vertex& b) noexcept { return a.exact != b.exact; }

private:
    static std::uint32_t exact_hash(const double* xyz) noexcept {
        const auto bits = [&](int axis) {
            return bits_as<std::uint64_t>(xyz[axis] + 0.0);  // makes a positive zero of a negative one
        };
        return static_cast<std::uint32_t>(mix64(mix64(mix64(bits(0)) ^ bits(1)) ^ bits(2)));
    }
};

constexpr std::size_t faces_a_part = std::size_t{1} << 13;
constexpr std::size_t vertex_grain = std::size_t{1} << 13;

struct FaceLess {
    bool operator()(const Face& a, const Face& b) const noexcept {
        return std::make_tuple(vertex_set(a), a.corners, a.source) < std::make_tuple(vertex_set(b), b.corners, b.source);
    }
};

Face face_of(const Array<std::uint32_t>& numbers, std::size_t triangle) {
    Face face{{numbers[3 * triangle], numbers[3 * triangle + 1], numbers[3 * triangle + 2]},
              static_cast<std::uint32_t>(triangle)};
    std::rotate(face.corners.begin(), std::min_element(face.corners.begin(), face.corners.end()), face.corners.end());
    return face;
}

bool is_collapsed(const Face& face) {
    const auto [a, b, c] = face.corners;
    return a == b || b == c || c == a;
}

/// Faces in parts by their smallest corner, and in one more those that have collapsed.
Distributed<Face> distribute_faces(const Array<std::uint32_t>& numbers, std::size_t vertices, const Parallel& parallel) {
    const std::size_t triangles = numbers.size() / 3;
    const std::size_t parts = parts_for(triangles, faces_a_part);
    return distribute<Face>(
        triangles, parts + 1, parallel,
        [&](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t t = begin; t != end; ++t) {
                Face face = face_of(numbers, t);
                if (is_collapsed(face)) {
                    sort_briefly(face.corners.begin(),
                                 face.corners.end());  // without orientation; two corners may be smallest
                    emit(parts, face);
                } else {
                    emit(part_of_number(face.corners[0], vertices, parts), face);
                }
            }
        },
        parallel.memory());
}

/// Of corners with the numbers of their vertices, of which there are so many.
void put_in_order(const Array<std::uint32_t>& numbers, std::size_t vertices, const Parallel& parallel, GridMesh& grid) {
    Distributed<Face> parts = distribute_faces(numbers, vertices, parallel);
    const std::size_t whole = parts.size() - 1;
    std::vector<PartSort<Face>> workers(static_cast<std::size_t>(parallel.threads()));
    parallel.run(whole, [&](std::size_t part, int worker) {
        workers[static_cast<std::size_t>(worker)].run(
            parts.of(part), [](const Face& face) { return face.corners[0]; }, FaceLess{});
    });
    const std::span<Face> collapsed = parts.of(whole);
    sort_in_parallel(collapsed, FaceLess{}, parallel);
    grid.collapsed.assign(collapsed.begin(), collapsed.end());
    grid.faces = std::move(parts.items);
    grid.faces.set_size(parts.firsts[whole]);
}

constexpr std::size_t sides_a_part = std::size_t{1} << 14;

using Ends = std::array<std::uint32_t, 2>;

struct EdgeSide {
    Ends ends;
    std::uint32_t side;
};

/// The vertices of the edge on which a side lies, the lower first.
Ends ends_of(const GridMesh& mesh, std::uint32_t side) {
    const auto& corners = mesh.faces[side / 3].corners;
    const auto [lower, upper] = std::minmax(corners[side % 3], corners[(side % 3 + 1) % 3]);
    return {lower, upper};
}

/// By lower vertex, then upper, then side.
Array<EdgeSide> sorted_sides(const GridMesh& mesh, const Parallel& parallel) {
    const std::size_t vertices = mesh.vertices.size();
    const std::size_t count = parts_for(3 * mesh.faces.size(), sides_a_part);
    Distributed<EdgeSide> parts = distribute<EdgeSide>(
        mesh.faces.size(), count, parallel,
        [&](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t side = 3 * begin; side != 3 * end; ++side) {
                const auto number = static_cast<std::uint32_t>(side);
                const Ends ends = ends_of(mesh, number);
                emit(part_of_number(ends[0], vertices, count), EdgeSide{ends, number});
            }
        },
        parallel.memory());
    std::vector<PartSort<EdgeSide>> workers(static_cast<std::size_t>(parallel.threads()));
    parallel.run(parts.size(), [&](std::size_t part, int worker) {
        workers[static_cast<std::size_t>(worker)].run(
            parts.of(part), [](const EdgeSide& side) { return side.ends[0]; },
            [](const EdgeSide& a, const EdgeSide& b) {
                return a.ends[1] != b.ends[1] ? a.ends[1] < b.ends[1] : a.side < b.side;
            });
    });
    return std::move(parts.items);
}

}  // namespace

GridMesh make_grid_mesh(const MeshView& mesh, const Frame& frame, const MeshCheck& measured, const Parallel& parallel) {
    assert(mesh.triangle_count < std::numeric_limits<std::uint32_t>::max() / 3);
    GridMesh grid(parallel.memory());
    grid.grid_mm = measured.grid_mm;
    with_reader(mesh, placing_of(mesh, frame), measured.grid_mm, [&](const auto& read) {
        const GridCorners<std::decay_t<decltype(read)>> corners{read, PlacedReader(mesh, {}), MortonOrder(measured)};
        const VertexNumbers numbers(corners, mesh.triangle_count, parallel);
        grid.joined = numbers.joined();
        grid.vertices.resize_discarding(numbers.vertices.size());
        parallel.run_ranges(numbers.vertices.size(), vertex_grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t v = begin; v != end; ++v) {
                grid.vertices[v] = numbers.vertices[v].place;
            }
        });
        put_in_order(numbers.of_corners, numbers.vertices.size(), parallel, grid);
    });
    return grid;
}

GridMesh make_exact_mesh(const WeldedMesh& mesh, const Parallel& parallel) {
    GridMesh exact(parallel.memory());
    exact.vertices.resize_discarding(mesh.vertex_count);
    put_in_order(mesh.indices, mesh.vertex_count, parallel, exact);
    return exact;
}

EdgeTable::EdgeTable(const GridMesh& mesh, const Parallel& parallel)
    : mesh_(mesh), first_sides_(parallel.memory()), sides_(parallel.memory()), irregular_(parallel.memory()) {
    const Array<EdgeSide> sorted = sorted_sides(mesh, parallel);
    sides_.resize_discarding(sorted.size());
    number_where(
        sorted.size(), parallel, [&](std::size_t i) { return i == 0 || sorted[i].ends != sorted[i - 1].ends; },
        [&](std::size_t count) { first_sides_.resize_discarding(count + 1); },
        [&](std::size_t i, std::uint32_t edge, bool is_first) {
            sides_[i] = sorted[i].side;
            if (is_first) {
                first_sides_[edge] = static_cast<std::uint32_t>(i);
            }
        });
    first_sides_[size()] = static_cast<std::uint32_t>(sorted.size());
    irregular_ = indices_where(size(), parallel, parallel.memory(),
                               [&](std::size_t edge) { return sides(edge).size() != 2 || !is_balanced(edge); });
    std::copy_if(irregular_.begin(), irregular_.end(), std::back_inserter(boundary_),
                 [&](std::uint32_t edge) { return sides(edge).size() == 1; });
}

EdgeTable::Edge EdgeTable::operator[](std::size_t edge) const noexcept {
    const auto [lower, upper] = ends_of(mesh_, sides_[first_sides_[edge]]);
    return {lower, upper};
}

bool EdgeTable::joins(std::uint32_t a, std::uint32_t b) const noexcept {
    const Ends wanted = {std::min(a, b), std::max(a, b)};
    const auto ends_at = [&](std::uint32_t first_side) { return ends_of(mesh_, sides_[first_side]); };
    const std::uint32_t* const end = first_sides_.begin() + size();
    const std::uint32_t* const found =
        std::partition_point(first_sides_.begin(), end, [&](std::uint32_t first) { return ends_at(first) < wanted; });
    return found != end && ends_at(*found) == wanted;
}

}  // namespace lamella
