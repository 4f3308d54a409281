#include "mesh/check/grid_mesh.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <limits>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "base/number_table.hpp"
#include "base/parallel_sort.hpp"
#include "mesh/measure.hpp"
#include "slicing/grid/vertex_hash.hpp"

namespace lamella {

namespace {

/// A vertex on the grid, and a hash of its coordinates as they are.
struct Vertex {
    GridVertex place;
    std::uint32_t exact;
};

/// Numbers vertices in the order in which they come; its memory is kept.
class VertexTable {
public:
    void clear() {
        numbers_.clear(std::max(found_.size(), least_room));  // as many as last time are to be expected
        found_.clear();
    }

    std::uint32_t number(const Vertex& vertex) {
        const std::uint32_t number = numbers_.number(
            hash_of(vertex.place), [&](std::uint32_t i) { return found_[i].place == vertex.place; },
            [&](std::uint32_t i) { return hash_of(found_[i].place); });
        if (number == found_.size()) {
            found_.push_back(vertex);
        }
        joined_ = joined_ || found_[number].exact != vertex.exact;
        return number;
    }

    const std::vector<Vertex>& found() const noexcept { return found_; }
    /// True if it ever gave one number to vertices that differ as they are.
    bool joined() const noexcept { return joined_; }

private:
    static constexpr std::size_t least_room = 512;

    std::vector<Vertex> found_;
    NumberTable numbers_;
    bool joined_ = false;
};

/// Nine calls of run(). Corners are numbered within ranges of triangles, each by a hash table in the cache; what the ranges
/// have found is sorted, and then numbered: O(n) expected for the corners, O(v log v) for v vertices.
/// Coordinates are compared by hashes of 32 bits: that the only difference is missed has a chance of 2^-32.
///
/// Triangles that follow one another share most of their vertices: each range of them is numbered by itself first, so that
/// only what it found need be brought together with what the others found.
///
///     range 0: corners a b c  b d c   ->  a b c d   numbers 0 1 2  1 3 2
///     range 1: corners c d e  d f e   ->  c d e f   numbers 0 1 2  1 3 2   ->  all: a b c d e f
class Numbering {
public:
    Numbering(const MeshView& mesh, const Frame& frame, const MeshCheck& measured, const Parallel& parallel)
        : mesh_(mesh),
          placing_(placing_of(mesh, frame)),
          grid_mm_(measured.grid_mm),
          order_(measured),
          parallel_(parallel),
          ranges_(ranges_for(mesh.triangle_count, parallel)),
          of_corners_(parallel.memory()),
          of_found_(parallel.memory()),
          tables_(static_cast<std::size_t>(parallel.threads())) {}

    /// Fills in vertices and `joined`; the number of each corner, three a triangle.
    Array<std::uint32_t> run(GridMesh& grid) {
        number_ranges();
        number_found(sort_found(), grid);
        rename_corners();
        grid.joined = grid.joined ||
                      std::any_of(tables_.begin(), tables_.end(), [](const VertexTable& table) { return table.joined(); });
        return std::move(of_corners_);
    }

private:
    /// A vertex that some range has found.
    struct Item {
        std::uint64_t key;  ///< in Morton order
        Vertex vertex;
        std::uint32_t number;  ///< among all that were found
    };

    std::size_t first_triangle(std::size_t range) const noexcept { return mesh_.triangle_count * range / ranges_; }

    /// Leaves each corner its vertex's number among what its range has found.
    void number_ranges() {
        found_.resize(ranges_);
        of_corners_.resize_discarding(3 * mesh_.triangle_count);
        const ExactReader exact(mesh_);
        with_reader(mesh_, placing_, grid_mm_, [&](const auto& read) {
            parallel_.run(ranges_, [&](std::size_t range, int worker) {
                VertexTable& table = tables_[static_cast<std::size_t>(worker)];
                table.clear();
                for (std::size_t t = first_triangle(range); t != first_triangle(range + 1); ++t) {
                    const GridTriangle places = read(t);
                    const GridTriangle as_they_are = exact(t);
                    for (std::size_t i = 0; i < 3; ++i) {
                        const auto hash = static_cast<std::uint32_t>(hash_of(as_they_are[i]));
                        of_corners_[3 * t + i] = table.number({places[i], hash});
                    }
                }
                found_[range] = table.found();
            });
        });
    }

    /// What the ranges have found, in the order of vertices. Frees it there.
    Array<Item> sort_found() {
        firsts_.assign(ranges_ + 1, 0);
        for (std::size_t range = 0; range < ranges_; ++range) {
            firsts_[range + 1] = firsts_[range] + static_cast<std::uint32_t>(found_[range].size());
        }
        Array<Item> items(parallel_.memory());
        items.resize_discarding(firsts_.back());
        parallel_.run(ranges_, [&](std::size_t range, int) {
            std::uint32_t number = firsts_[range];
            for (const Vertex& vertex : std::exchange(found_[range], {})) {
                items[number] = {order_.key(vertex.place), vertex, number};
                ++number;
            }
        });
        sort_in_parallel(
            items.span(),
            [](const Item& a, const Item& b) { return a.key != b.key ? a.key < b.key : a.vertex.place < b.vertex.place; },
            parallel_, parallel_.memory());
        return items;
    }

    /// All vertices in order; of_found_ becomes the number of each that a range has found. Whether a vertex stands for
    /// several is seen where they follow one another.
    void number_found(const Array<Item>& items, GridMesh& grid) {
        std::atomic<bool> joined = false;
        of_found_.resize_discarding(items.size());
        number_where(
            items.size(), parallel_,
            [&](std::size_t i) { return i == 0 || !(items[i].vertex.place == items[i - 1].vertex.place); },
            [&](std::size_t count) { grid.vertices.resize_discarding(count); },
            [&](std::size_t i, std::uint32_t number, bool is_new) {
                of_found_[items[i].number] = number;
                if (is_new) {
                    grid.vertices[number] = items[i].vertex.place;
                } else if (items[i].vertex.exact != items[i - 1].vertex.exact) {
                    joined = true;
                }
            });
        grid.joined = joined;
    }

    void rename_corners() {
        parallel_.run(ranges_, [&](std::size_t range, int) {
            const std::uint32_t* const of_own = of_found_.data() + firsts_[range];
            for (std::size_t corner = 3 * first_triangle(range); corner != 3 * first_triangle(range + 1); ++corner) {
                of_corners_[corner] = of_own[of_corners_[corner]];
            }
        });
    }

    const MeshView& mesh_;
    Placing placing_;
    double grid_mm_;
    MortonOrder order_;
    const Parallel& parallel_;
    std::size_t ranges_;
    Array<std::uint32_t> of_corners_;
    Array<std::uint32_t> of_found_;
    std::vector<VertexTable> tables_;         ///< by worker
    std::vector<std::vector<Vertex>> found_;  ///< by range
    std::vector<std::uint32_t> firsts_;       ///< by range: its first vertex among all that were found
};

constexpr std::size_t faces_a_part = std::size_t{1} << 13;

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
                    std::sort(face.corners.begin(), face.corners.end());  // without orientation; two corners may be smallest
                    emit(parts, face);
                } else {
                    emit(part_of_number(face.corners[0], vertices, parts), face);
                }
            }
        },
        parallel.memory());
}

}  // namespace

GridMesh make_grid_mesh(const MeshView& mesh, const Frame& frame, const MeshCheck& measured, const Parallel& parallel) {
    assert(mesh.triangle_count < std::numeric_limits<std::uint32_t>::max() / 3);
    GridMesh grid(parallel.memory());
    grid.grid_mm = measured.grid_mm;
    const Array<std::uint32_t> numbers = Numbering(mesh, frame, measured, parallel).run(grid);
    Distributed<Face> parts = distribute_faces(numbers, grid.vertices.size(), parallel);
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
    return grid;
}

}  // namespace lamella
