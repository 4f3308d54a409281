#include "models/lattice.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstddef>

namespace lamella::models {

namespace {

// A cube's corner is a number of three bits: x, y << 1, z << 2. Kuhn's edges lead from a corner to one with more bits
// set.
struct CubeEdge {
    std::uint8_t from = 0;
    std::uint8_t to = 0;
};
constexpr std::size_t edge_count = 19;

constexpr std::array<CubeEdge, edge_count> cube_edges = [] {
    std::array<CubeEdge, edge_count> edges{};
    std::size_t count = 0;
    for (std::uint8_t from = 0; from < 8; ++from) {
        for (std::uint8_t to = 0; to < 8; ++to) {
            if (from != to && (from & to) == from) {
                edges[count++] = {from, to};
            }
        }
    }
    return edges;
}();

// The edge between two corners, in either order.
constexpr auto edges_by_corners = [] {
    std::array<std::array<std::uint8_t, 8>, 8> table{};
    for (std::uint8_t e = 0; e < edge_count; ++e) {
        table[cube_edges[e].from][cube_edges[e].to] = e;
        table[cube_edges[e].to][cube_edges[e].from] = e;
    }
    return table;
}();

std::uint8_t edge_between(unsigned a, unsigned b) {
    return edges_by_corners[a][b];
}

constexpr std::array<std::array<unsigned, 4>, 6> tetrahedra{
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

// The triangles in a cube for one set of inside corners.
struct CubeCase {
    std::uint8_t triangles = 0;
    std::uint32_t edges_used = 0;
    std::array<std::uint8_t, 36> edges{};
};

using Offset = std::array<int, 3>;

Offset corner_offset(unsigned corner) {
    return {static_cast<int>(corner & 1), static_cast<int>(corner >> 1 & 1), static_cast<int>(corner >> 2)};
}

Offset minus(const Offset& a, const Offset& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// Twice the middle of an edge. Where the surface crosses the edge does not affect the orientation of triangles.
Offset middle(std::uint8_t edge) {
    const Offset a = corner_offset(cube_edges[edge].from);
    const Offset b = corner_offset(cube_edges[edge].to);
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

// Adds a triangle, oriented so that its normal has a positive component along `outwards`.
void add_triangle(CubeCase& cube, std::array<std::uint8_t, 3> e, const Offset& outwards) {
    const Offset u = minus(middle(e[1]), middle(e[0]));
    const Offset v = minus(middle(e[2]), middle(e[0]));
    const int facing = (u[1] * v[2] - u[2] * v[1]) * outwards[0] + (u[2] * v[0] - u[0] * v[2]) * outwards[1] +
                       (u[0] * v[1] - u[1] * v[0]) * outwards[2];
    if (facing < 0) {
        std::swap(e[1], e[2]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        cube.edges[cube.triangles * 3U + i] = e[i];
        cube.edges_used |= 1U << e[i];
    }
    ++cube.triangles;
}

// `mask` has a bit for each corner of the cube that lies inside.
void add_tetrahedron(CubeCase& cube, unsigned mask, const std::array<unsigned, 4>& corners) {
    std::array<unsigned, 4> in{};
    std::array<unsigned, 4> out{};
    std::size_t ins = 0;
    std::size_t outs = 0;
    for (const unsigned corner : corners) {
        ((mask >> corner & 1) != 0 ? in[ins++] : out[outs++]) = corner;
    }
    if (ins == 0 || outs == 0) {
        return;
    }
    Offset outwards{};
    for (std::size_t i = 0; i < ins; ++i) {
        for (std::size_t o = 0; o < outs; ++o) {
            const Offset d = minus(corner_offset(out[o]), corner_offset(in[i]));
            outwards = {outwards[0] + d[0], outwards[1] + d[1], outwards[2] + d[2]};
        }
    }
    if (ins == 2) {
        const std::uint8_t a = edge_between(in[0], out[0]);
        const std::uint8_t b = edge_between(in[0], out[1]);
        const std::uint8_t c = edge_between(in[1], out[1]);
        const std::uint8_t d = edge_between(in[1], out[0]);
        add_triangle(cube, {a, b, c}, outwards);
        add_triangle(cube, {a, c, d}, outwards);
    } else {
        const std::array<unsigned, 4>& others = ins == 1 ? out : in;
        const unsigned lone = ins == 1 ? in[0] : out[0];
        add_triangle(cube, {edge_between(lone, others[0]), edge_between(lone, others[1]), edge_between(lone, others[2])},
                     outwards);
    }
}

// By the set of inside corners.
const std::array<CubeCase, 256>& cube_cases() {
    static const auto cases = [] {
        std::array<CubeCase, 256> made{};
        for (unsigned mask = 0; mask < 256; ++mask) {
            for (const std::array<unsigned, 4>& corners : tetrahedra) {
                add_tetrahedron(made[mask], mask, corners);
            }
        }
        return made;
    }();
    return cases;
}

// The nodes of one lattice plane: their values and whether they lie inside. Nodes outside the rows' spans keep their
// initial values.
struct NodePlane {
    std::vector<double> values;
    std::vector<std::uint8_t> inside;
    std::vector<RowSpan> spans;

    explicit NodePlane(const Lattice& lattice)
        : values(std::size_t{lattice.nx} * lattice.ny, -1.0),
          inside(std::size_t{lattice.nx} * lattice.ny, 0),
          spans(lattice.ny) {}

    void fill(Field& field, const Lattice& lattice, std::uint32_t k) {
        for (std::uint32_t j = 0; j < lattice.ny; ++j) {
            double* row = values.data() + std::size_t{j} * lattice.nx;
            std::uint8_t* row_inside = inside.data() + std::size_t{j} * lattice.nx;
            RowSpan& span = spans[j];
            std::fill(row + span.first, row + span.last, -1.0);
            std::fill(row_inside + span.first, row_inside + span.last, std::uint8_t{0});
            const bool border = k == 0 || k + 1 == lattice.nz || j == 0 || j + 1 == lattice.ny;
            span = border ? RowSpan{} : field.fill_row(k, j, row);
            assert(span.first == span.last || (span.first > 0 && span.last < lattice.nx));
            for (std::uint32_t i = span.first; i < span.last; ++i) {
                row_inside[i] = row[i] >= 0 ? 1 : 0;
            }
        }
    }
};

// The layer of cubes between two planes of nodes.
class Slab {
public:
    Slab(const Lattice& lattice, const NodePlane& lower, const NodePlane& upper, std::uint32_t k)
        : lattice_(lattice), planes_{&lower, &upper}, k_(k) {}

    // Calls visit(i, j, case) for each cube that the surface passes through.
    template <class Visit>
    void for_each_cube(std::vector<std::uint8_t>& columns, Visit visit) const {
        const std::size_t nx = lattice_.nx;
        const std::array<CubeCase, 256>& cases = cube_cases();
        columns.resize(nx);
        for (std::uint32_t j = 0; j + 1 < lattice_.ny; ++j) {
            const RowSpan span = common_span(j);
            const std::uint8_t* l = planes_[0]->inside.data() + j * nx;
            const std::uint8_t* u = planes_[1]->inside.data() + j * nx;
            for (std::size_t i = span.first; i < span.last; ++i) {
                columns[i] = static_cast<std::uint8_t>(l[i] | l[i + nx] << 2 | u[i] << 4 | u[i + nx] << 6);
            }
            for (std::uint32_t i = span.first; i + 1 < span.last; ++i) {
                const auto mask = static_cast<std::uint8_t>(columns[i] | columns[i + 1] << 1);
                if (mask != 0 && mask != 255) {
                    visit(i, j, cases[mask]);
                }
            }
        }
    }

    // The position from 0 to 1 where the surface crosses the edge. It is kept away from the ends so that no triangle
    // degenerates.
    double crossing(std::uint32_t i, std::uint32_t j, const CubeEdge& edge) const noexcept {
        constexpr double nearest = 0.05;
        const double from = node(i, j, edge.from);
        const double to = node(i, j, edge.to);
        return std::clamp(from / (from - to), nearest, 1 - nearest);
    }

    std::uint32_t k() const noexcept { return k_; }

private:
    // The union of the spans of rows j and j + 1 in both planes, with one more node on each side.
    RowSpan common_span(std::uint32_t j) const noexcept {
        RowSpan common{lattice_.nx, 0};
        for (const NodePlane* plane : planes_) {
            for (const RowSpan& span : {plane->spans[j], plane->spans[j + 1]}) {
                if (span.first < span.last) {
                    common.first = std::min(common.first, span.first - 1);
                    common.last = std::max(common.last, span.last + 1);
                }
            }
        }
        return common;
    }

    double node(std::uint32_t i, std::uint32_t j, unsigned corner) const noexcept {
        const std::size_t at = std::size_t{j + (corner >> 1 & 1)} * lattice_.nx + i + (corner & 1);
        return planes_[corner >> 2]->values[at];
    }

    const Lattice& lattice_;
    std::array<const NodePlane*, 2> planes_;
    std::uint32_t k_;
};

// Calls visit_slab for every stride-th slab. Stops when it returns false.
template <class VisitSlab>
bool walk(Field& field, const Lattice& lattice, std::uint32_t stride, VisitSlab visit_slab) {
    field.prepare(lattice);
    NodePlane lower(lattice);
    NodePlane upper(lattice);
    std::uint32_t filled = lattice.nz;
    for (std::uint32_t k = stride / 2; k + 1 < lattice.nz; k += stride) {
        if (filled == k) {
            std::swap(lower, upper);
        } else {
            lower.fill(field, lattice, k);
        }
        upper.fill(field, lattice, k + 1);
        filled = k + 1;
        if (!visit_slab(Slab(lattice, lower, upper, k))) {
            return false;
        }
    }
    return true;
}

template <class Visit>
void for_each_edge(const CubeCase& cube, Visit visit) {
    for (std::uint32_t left = cube.edges_used; left != 0; left &= left - 1) {
        visit(static_cast<std::size_t>(std::countr_zero(left)));
    }
}

// Sum of the z extents of a cube's triangles, in lattice steps.
double cube_extent(const Slab& slab, std::uint32_t i, std::uint32_t j, const CubeCase& cube) {
    std::array<double, edge_count> z{};
    for_each_edge(cube, [&](std::size_t e) {
        const CubeEdge edge = cube_edges[e];
        z[e] = (edge.from >> 2) != (edge.to >> 2) ? slab.crossing(i, j, edge) : edge.from >> 2;
    });
    double sum = 0;
    for (std::size_t t = 0; t < cube.triangles; ++t) {
        const auto [low, high] = std::minmax({z[cube.edges[t * 3]], z[cube.edges[t * 3 + 1]], z[cube.edges[t * 3 + 2]]});
        sum += high - low;
    }
    return sum;
}

}  // namespace

Lattice lattice_around(const Field& field, double dx, double dz) noexcept {
    Lattice lattice;
    const auto nodes = [](double length, double step) { return static_cast<std::uint32_t>(length / step) + 4; };
    lattice.nx = nodes(2 * field.half_x(), dx);
    lattice.ny = nodes(2 * field.half_y(), dx);
    lattice.nz = nodes(1, dz);
    lattice.dx = dx;
    lattice.dz = dz;
    lattice.x0 = -0.5 * dx * (lattice.nx - 1);
    lattice.y0 = -0.5 * dx * (lattice.ny - 1);
    lattice.z0 = 0.5 - 0.5 * dz * (lattice.nz - 1);
    return lattice;
}

RowSpan span_between(const Lattice& lattice, double low, double high) noexcept {
    const double most = static_cast<double>(lattice.nx) - 1;
    const double first = std::max((low - lattice.x0) / lattice.dx - 1, 1.0);
    const double last = std::min((high - lattice.x0) / lattice.dx + 2, most);
    return first < last ? RowSpan{static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last)} : RowSpan{};
}

SurfaceSize measure(Field& field, const Lattice& lattice, std::uint32_t stride, bool extents) {
    assert(stride > 0);
    std::uint64_t triangles = 0;
    std::uint64_t slabs = 0;
    double steps = 0;
    std::vector<std::uint8_t> columns;
    walk(field, lattice, stride, [&](const Slab& slab) {
        ++slabs;
        slab.for_each_cube(columns, [&](std::uint32_t i, std::uint32_t j, const CubeCase& cube) {
            triangles += cube.triangles;
            steps += extents ? cube_extent(slab, i, j, cube) : 0;
        });
        return true;
    });
    const double scale_up = static_cast<double>(lattice.nz - 1) / static_cast<double>(std::max<std::uint64_t>(slabs, 1));
    return {static_cast<double>(triangles) * scale_up, steps * lattice.dz * scale_up};
}

bool march(Field& field, const Lattice& lattice, Scale scale, Emitter& out) {
    std::array<Vertex, edge_count> vertices{};
    std::vector<std::uint8_t> columns;
    return walk(field, lattice, 1, [&](const Slab& slab) {
        slab.for_each_cube(columns, [&](std::uint32_t i, std::uint32_t j, const CubeCase& cube) {
            for_each_edge(cube, [&](std::size_t e) {
                const CubeEdge edge = cube_edges[e];
                const double t = slab.crossing(i, j, edge);
                const auto steps = [&](std::uint32_t base, unsigned bit) {
                    const double whole = base + (edge.from >> bit & 1);
                    return ((edge.from ^ edge.to) >> bit & 1) != 0 ? whole + t : whole;
                };
                vertices[e] = {static_cast<float>((lattice.x0 + lattice.dx * steps(i, 0)) * scale.xy),
                               static_cast<float>((lattice.y0 + lattice.dx * steps(j, 1)) * scale.xy),
                               static_cast<float>((lattice.z0 + lattice.dz * steps(slab.k(), 2)) * scale.z)};
            });
            for (std::size_t t = 0; t < cube.triangles; ++t) {
                out.add_splittable(
                    {vertices[cube.edges[t * 3]], vertices[cube.edges[t * 3 + 1]], vertices[cube.edges[t * 3 + 2]]});
            }
        });
        return out.flush();
    });
}

}  // namespace lamella::models
