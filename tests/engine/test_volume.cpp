// Computes the volume certificate in another way. A closed mesh is split into slabs at the planes of a slice. The volume
// between two planes follows from the facets' walls alone (Gauss, x), or from their slopes and the area of the contours
// above (Gauss, z). The first must sum to the volume of the mesh. Agreement of both, slab by slab, checks the contours'
// areas.
#include <algorithm>
#include <cmath>
#include <map>

#include <catch2/catch.hpp>

#include "engine/rounds.hpp"
#include "engine/slicing.hpp"
#include "oracle/oracle.hpp"

using lamella::Layer;
using lamella::SliceResult;
using lamella::models::Shape;
using oracle::Int128;

namespace {

constexpr std::uint64_t model_triangles = 160 * rounds(125);

/// Coordinates in grid units, as long double where they are not whole: it has 64 bits, and coordinates take 31.
struct Corner {
    long double x = 0;
    long double y = 0;
    long double z = 0;
};

/// A convex polygon: a part of one facet.
using Piece = std::vector<Corner>;

/// The part of `piece` above z, or below it.
Piece clipped(const Piece& piece, long double z, bool above) {
    Piece kept;
    for (std::size_t i = 0; i < piece.size(); ++i) {
        const Corner& a = piece[i];
        const Corner& b = piece[(i + 1) % piece.size()];
        if ((a.z > z) == above) {
            kept.push_back(a);
        }
        if ((a.z > z) != (b.z > z)) {
            const Corner& low = a.z < b.z ? a : b;
            const Corner& high = a.z < b.z ? b : a;
            const long double part = (z - low.z) / (high.z - low.z);
            kept.push_back({low.x + part * (high.x - low.x), low.y + part * (high.y - low.y), z});
        }
    }
    return kept;
}

struct Slab {
    long double by_walls = 0;
    long double by_slopes = 0;  ///< without the share of the contours above
};

void add(Slab& slab, const Piece& piece, long double bottom) {
    for (std::size_t i = 1; i + 1 < piece.size(); ++i) {
        const Corner& a = piece[0];
        const Corner& b = piece[i];
        const Corner& c = piece[i + 1];
        slab.by_walls += (a.x + b.x + c.x) / 6 * ((b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y));
        slab.by_slopes += ((a.z + b.z + c.z) / 3 - bottom) / 2 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
    }
}

/// Slab i ends at plane i. The last slab lies above all planes.
std::vector<Slab> slabs_of(std::span<const oracle::Triangle> triangles, const SliceResult& result) {
    std::vector<Slab> slabs(result.layers.size() + 1);
    const auto plane = [&](std::size_t i) { return static_cast<long double>(result.layers[i].plane.z()); };
    for (const oracle::Triangle& t : triangles) {
        Piece rest;
        for (const lamella::GridVertex v : t) {
            rest.push_back({static_cast<long double>(v.x), static_cast<long double>(v.y), static_cast<long double>(v.z)});
        }
        for (std::size_t i = 0; i < slabs.size() && !rest.empty(); ++i) {
            const bool last = i + 1 == slabs.size();
            add(slabs[i], last ? rest : clipped(rest, plane(i), false), i > 0 ? plane(i - 1) : plane(0));
            rest = last ? Piece{} : clipped(rest, plane(i), true);
        }
    }
    return slabs;
}

/// Six times the volume, exactly.
Int128 six_volumes(std::span<const oracle::Triangle> triangles) {
    Int128 sum = 0;
    for (const oracle::Triangle& t : triangles) {
        const auto minor = [&](std::size_t i) {
            const lamella::GridVertex u = t[(i + 1) % 3];
            const lamella::GridVertex v = t[(i + 2) % 3];
            return Int128{t[i].z} * (std::int64_t{u.x} * v.y - std::int64_t{u.y} * v.x);
        };
        sum += minor(0) + minor(1) + minor(2);
    }
    return sum;
}

/// Area and perimeter of a layer's contours.
std::pair<long double, long double> sizes_of(const SliceResult& result, const Layer& layer) {
    long double area = 0;
    long double perimeter = 0;
    for (const lamella::Contour& contour : result.contours_of(layer)) {
        area += static_cast<long double>(contour.twice_area.to_double()) / 2;
        perimeter += rings::perimeter(result.points_of(contour));
    }
    return {area, perimeter};
}

const std::map<std::string, shapes::Soup>& closed_meshes() {
    static const std::map<std::string, shapes::Soup> all = [] {
        const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
        return std::map<std::string, shapes::Soup>{
            {"hollow ball", shapes::joined({ball, shapes::flipped(shapes::octasphere({1, 2, 1}, 5, 2))})},
            {"crossing balls far away",
             shapes::moved(shapes::joined({ball, shapes::moved(ball, {3, 4, 5})}), {900, -900, 900})},
            {"boxes that share an edge",
             shapes::joined({shapes::box({0, 0, 0}, {4, 4, 4}), shapes::box({4, 4, 0}, {8, 8, 4})})},
            {"gyroid", generated(Shape::gyroid, model_triangles)},
            {"bone", generated(Shape::bone, model_triangles)},
            {"torus", generated(Shape::torus, model_triangles)}};
    }();
    return all;
}

}  // namespace

TEST_CASE("the volumes of slabs sum to the mesh's volume and agree with the contours", "[engine][volume]") {
    for (const auto& [name, mesh] : closed_meshes()) {
        const SliceResult result = sliced(mesh, uniform(0.25));
        const std::vector<oracle::Triangle> triangles = oracle::quantise(mesh, result.info.grid_mm);
        const std::vector<Slab> slabs = slabs_of(triangles, result);
        const long double volume = static_cast<long double>(six_volumes(triangles)) / 6;
        const long double cube_mm3 =
            static_cast<long double>(result.info.grid_mm) * result.info.grid_mm * result.info.grid_mm;
        const auto certificate = value_of(audits::volume_of(result, view_of(mesh)));
        CHECK(certificate.verdict == lamella::VolumeVerdict::holds);
        REQUIRE(certificate.slab_mm3.size() == slabs.size());
        long double sum = 0;
        for (std::size_t i = 0; i < slabs.size(); ++i) {
            INFO(name << ", slab " << i);
            sum += slabs[i].by_walls;
            REQUIRE(std::abs(slabs[i].by_walls * cube_mm3 - certificate.slab_mm3[i]) <= 1e-12L * volume * cube_mm3);
            // Below the first plane, heights count from the plane itself, so its contours add nothing.
            const bool inner = i > 0 && i < result.layers.size();
            const long double rise =
                inner ? static_cast<long double>(result.layers[i].plane.z() - result.layers[i - 1].plane.z()) : 0;
            const auto [area, perimeter] =
                inner ? sizes_of(result, result.layers[i]) : std::pair<long double, long double>{};
            REQUIRE(std::abs(slabs[i].by_walls - slabs[i].by_slopes - rise * area) <= rise * perimeter + 1e-12L * volume);
        }
        INFO(name);
        CHECK(std::abs(sum - volume) <= 1e-12L * std::abs(volume));
    }
}
