#include "models/lattice.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstddef>

namespace lamella::models {

namespace {

// A cube's corner is a number of three bits: x, y << 1, z << 2. Kuhn's edges lead from a corner to one with more bits
// set; one is a number of six bits, those of its lower and its upper corner.
constexpr std::size_t edge_numbers = 64;

constexpr unsigned edge_between(unsigned a, unsigned b) {
    return std::min(a, b) << 3 | std::max(a, b);
}
constexpr unsigned lower_corner(std::size_t edge) {
    return static_cast<unsigned>(edge >> 3);
}
constexpr unsigned upper_corner(std::size_t edge) {
    return edge & 7;
}

struct Tetrahedron {
    std::array<unsigned, 4> corners;
    bool mirrored;
};
constexpr std::array<Tetrahedron, 6> tetrahedra{{{{0, 1, 3, 7}, false},
                                                 {{0, 1, 5, 7}, true},
                                                 {{0, 2, 3, 7}, true},
                                                 {{0, 2, 6, 7}, false},
                                                 {{0, 4, 5, 7}, false},
                                                 {{0, 4, 6, 7}, true}}};

// The triangles in a cube for one set of inside corners.
struct CubeCase {
    std::uint8_t triangles = 0;
    std::uint64_t edges_used = 0;  // a bit for each
    std::array<std::uint8_t, 36> edges{};

    void add(unsigned a, unsigned b, unsigned c) {
        for (const unsigned edge : {a, b, c}) {
            edges_used |= std::uint64_t{1} << edge;
        }
        const std::size_t at = triangles++ * std::size_t{3};
        edges[at] = static_cast<std::uint8_t>(a);
        edges[at + 1] = static_cast<std::uint8_t>(b);
        edges[at + 2] = static_cast<std::uint8_t>(c);
    }
};

// `mask` has a bit for each corner of the cube that lies inside. Triangles look outwards: they are turned where the inside
// corners and then the outside ones, both in the order of the tetrahedron, are an odd permutation of its corners.
void add_tetrahedron(CubeCase& cube, unsigned mask, const Tetrahedron& tetrahedron) {
    std::array<unsigned, 4> in{};
    std::array<unsigned, 4> out{};
    std::size_t ins = 0;
    std::size_t outs = 0;
    bool turned = tetrahedron.mirrored;
    for (const unsigned corner : tetrahedron.corners) {
        const bool inside = (mask >> corner & 1) != 0;
        turned = turned != (inside && outs % 2 != 0);
        (inside ? in[ins++] : out[outs++]) = corner;
    }
    const auto add = [&](unsigned a, unsigned b, unsigned c) { turned ? cube.add(a, c, b) : cube.add(a, b, c); };
    if (ins == 2) {
        const unsigned a = edge_between(in[0], out[0]);
        const unsigned c = edge_between(in[1], out[1]);
        add(a, edge_between(in[0], out[1]), c);
        add(a, c, edge_between(in[1], out[0]));
    } else if (ins == 1 || outs == 1) {
        const unsigned lone = ins == 1 ? in[0] : out[0];
        const std::array<unsigned, 4>& others = ins == 1 ? out : in;
        add(edge_between(lone, others[0]), edge_between(lone, others[1]), edge_between(lone, others[2]));
    }
}

// By the set of inside corners.
const std::array<CubeCase, 256>& cube_cases() {
    static const auto cases = [] {
        std::array<CubeCase, 256> made{};
        for (unsigned mask = 0; mask < 256; ++mask) {
            for (const Tetrahedron& tetrahedron : tetrahedra) {
                add_tetrahedron(made[mask], mask, tetrahedron);
            }
        }
        return made;
    }();
    return cases;
}

// The nodes of one lattice plane: their values and whether they lie inside.
struct NodePlane {
    std::vector<double> values;
    std::vector<std::uint8_t> inside;
    std::vector<std::uint8_t> rows;  // those with nodes that may lie inside; all other nodes are outside

    explicit NodePlane(const Lattice& lattice)
        : values(std::size_t{lattice.nx} * lattice.ny, -1.0),
          inside(std::size_t{lattice.nx} * lattice.ny, 0),
          rows(lattice.ny, 0) {}

    void fill(Field& field, const Lattice& lattice, std::uint32_t k) {
        const std::size_t nx = lattice.nx;
        for (std::uint32_t j = 1; j + 1 < lattice.ny; ++j) {  // The border counts as outside.
            double* row = values.data() + j * nx;
            const bool used = k > 0 && k + 1 < lattice.nz && field.fill_row(k, j, row);
            if (used || rows[j] != 0) {
                std::transform(row + 1, row + nx - 1, inside.data() + j * nx + 1,
                               [&](double value) { return static_cast<std::uint8_t>(used && value >= 0 ? 1 : 0); });
            }
            rows[j] = used ? 1 : 0;
        }
    }
};

// The layers of cubes between two planes of nodes, one after the other.
class Slabs {
public:
    Slabs(Field& field, const Lattice& lattice) : field_(field), lattice_(lattice), lower_(lattice), upper_(lattice) {
        field.prepare(lattice);
        columns_.resize(lattice.nx);
    }

    // Calls visit(i, j, case) for each cube of slab k that the surface passes through.
    template <class Visit>
    void for_each_cube(std::uint32_t k, Visit visit) {
        load(k);
        const std::size_t nx = lattice_.nx;
        const std::array<CubeCase, 256>& cases = cube_cases();
        for (std::uint32_t j = 0; j + 1 < lattice_.ny; ++j) {
            if ((lower_.rows[j] | lower_.rows[j + 1] | upper_.rows[j] | upper_.rows[j + 1]) == 0) {
                continue;
            }
            const std::uint8_t* l = lower_.inside.data() + j * nx;
            const std::uint8_t* u = upper_.inside.data() + j * nx;
            for (std::size_t i = 0; i < nx; ++i) {
                columns_[i] = static_cast<std::uint8_t>(l[i] | l[i + nx] << 2 | u[i] << 4 | u[i + nx] << 6);
            }
            for (std::uint32_t i = 0; i + 1 < nx; ++i) {
                const auto mask = static_cast<std::uint8_t>(columns_[i] | columns_[i + 1] << 1);
                if (mask != 0 && mask != 255) {
                    visit(i, j, cases[mask]);
                }
            }
        }
    }

    // For each edge of a cube that is crossed: visit(edge, position), from 0 to 1 where the surface crosses it. That is kept
    // away from the ends so that no triangle degenerates.
    template <class Visit>
    void for_each_crossing(std::uint32_t i, std::uint32_t j, const CubeCase& cube, Visit visit) const {
        constexpr double nearest = 0.05;
        for (std::uint64_t left = cube.edges_used; left != 0; left &= left - 1) {
            const auto edge = static_cast<std::size_t>(std::countr_zero(left));
            const double from = node(i, j, lower_corner(edge));
            const double to = node(i, j, upper_corner(edge));
            visit(edge, std::clamp(from / (from - to), nearest, 1 - nearest));
        }
    }

private:
    void load(std::uint32_t k) {
        if (k > 0 && filled_ == k) {
            std::swap(lower_, upper_);
        } else {
            lower_.fill(field_, lattice_, k);
        }
        upper_.fill(field_, lattice_, k + 1);
        filled_ = k + 1;
    }

    double node(std::uint32_t i, std::uint32_t j, unsigned corner) const noexcept {
        const std::size_t at = std::size_t{j + (corner >> 1 & 1)} * lattice_.nx + i + (corner & 1);
        return ((corner >> 2) != 0 ? upper_ : lower_).values[at];
    }

    Field& field_;
    const Lattice& lattice_;
    NodePlane lower_;
    NodePlane upper_;
    std::uint32_t filled_ = 0;  // the upper plane, once there is one
    std::vector<std::uint8_t> columns_;
};

}  // namespace

Lattice lattice_around(const Field& field, double dx, double dz) noexcept {
    Lattice lattice;
    const auto nodes = [](double length, double step) { return static_cast<std::uint32_t>(length / step) + 4; };
    lattice.nx = nodes(2 * field.half_x, dx);
    lattice.ny = nodes(2 * field.half_y, dx);
    lattice.nz = nodes(1, dz);
    lattice.dx = dx;
    lattice.dz = dz;
    lattice.x0 = -0.5 * dx * (lattice.nx - 1);
    lattice.y0 = -0.5 * dx * (lattice.ny - 1);
    lattice.z0 = 0.5 - 0.5 * dz * (lattice.nz - 1);
    return lattice;
}

SurfaceSize measure(Field& field, const Lattice& lattice, std::uint32_t stride, bool extents) {
    assert(stride > 0);
    Slabs slabs(field, lattice);
    std::uint64_t triangles = 0;
    std::uint64_t visited = 0;
    double steps = 0;
    for (std::uint32_t k = stride / 2; k + 1 < lattice.nz; k += stride) {
        ++visited;
        slabs.for_each_cube(k, [&](std::uint32_t i, std::uint32_t j, const CubeCase& cube) {
            triangles += cube.triangles;
            if (!extents) {
                return;
            }
            std::array<double, edge_numbers> z{};
            slabs.for_each_crossing(i, j, cube, [&](std::size_t edge, double position) {
                const unsigned low = lower_corner(edge) >> 2;
                z[edge] = low != upper_corner(edge) >> 2 ? position : low;
            });
            double sum = 0;
            for (std::size_t t = 0; t < cube.triangles; ++t) {
                const auto [low, high] =
                    std::minmax({z[cube.edges[t * 3]], z[cube.edges[t * 3 + 1]], z[cube.edges[t * 3 + 2]]});
                sum += high - low;
            }
            steps += sum;
        });
    }
    const double scale_up = static_cast<double>(lattice.nz - 1) / static_cast<double>(std::max<std::uint64_t>(visited, 1));
    return {static_cast<double>(triangles) * scale_up, steps * lattice.dz * scale_up};
}

bool march(Field& field, const Lattice& lattice, Scale scale, Emitter& out) {
    Slabs slabs(field, lattice);
    std::array<Vertex, edge_numbers> vertices{};
    for (std::uint32_t k = 0; k + 1 < lattice.nz; ++k) {
        slabs.for_each_cube(k, [&](std::uint32_t i, std::uint32_t j, const CubeCase& cube) {
            slabs.for_each_crossing(i, j, cube, [&](std::size_t edge, double position) {
                const auto steps = [&](std::uint32_t base, unsigned bit) {
                    const double whole = base + (lower_corner(edge) >> bit & 1);
                    return ((lower_corner(edge) ^ upper_corner(edge)) >> bit & 1) != 0 ? whole + position : whole;
                };
                vertices[edge] = {static_cast<float>((lattice.x0 + lattice.dx * steps(i, 0)) * scale.xy),
                                  static_cast<float>((lattice.y0 + lattice.dx * steps(j, 1)) * scale.xy),
                                  static_cast<float>((lattice.z0 + lattice.dz * steps(k, 2)) * scale.z)};
            });
            for (std::size_t t = 0; t < cube.triangles; ++t) {
                out.add_splittable(
                    {vertices[cube.edges[t * 3]], vertices[cube.edges[t * 3 + 1]], vertices[cube.edges[t * 3 + 2]]});
            }
        });
        if (!out.flush()) {
            return false;
        }
    }
    return true;
}

}  // namespace lamella::models
