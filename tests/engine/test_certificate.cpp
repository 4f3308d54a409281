// The ledger accounts for every triangle once, and reports all that no plane cuts. The volume certificate holds for every
// result that the engine makes from a closed mesh, says where it does not apply, and rejects damaged results. The volumes of
// its slabs are those of the facets, cut at the planes one by one.
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <tuple>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "oracle/oracle.hpp"

using namespace lamella;

namespace {

/// Counts shells, peaks and pits by definition. Each triangle is split at the planes. Its parts are joined to parts of
/// other triangles in the same slab that share a vertex there or a piece of an edge.
std::array<std::size_t, 3> pieces_of(const shapes::Soup& soup, const SliceResult& result) {
    struct Part {
        std::size_t set;
        bool meets_below;
        bool meets_above;
    };
    const auto slab_of = [&](std::int32_t z) {
        std::size_t slab = 0;
        while (slab < result.layers.size() && result.layers[slab].plane.z() < z) {
            ++slab;
        }
        return slab;
    };
    std::vector<std::size_t> parents;  // of the sets
    const auto find = [&](std::size_t set) {
        while (parents[set] != set) {
            set = parents[set];
        }
        return set;
    };
    std::vector<Part> parts;
    std::map<std::pair<std::size_t, std::pair<GridVertex, GridVertex>>, std::size_t> shared;
    for (const oracle::Triangle& t : oracle::quantise(soup, result.info.grid_mm)) {
        const std::array<std::size_t, 3> slabs = {slab_of(t[0].z), slab_of(t[1].z), slab_of(t[2].z)};
        const auto [low, high] = std::minmax({slabs[0], slabs[1], slabs[2]});
        for (std::size_t slab = low; slab <= high; ++slab) {
            const std::size_t set = parents.size();
            parents.push_back(set);
            const auto join = [&](const auto& key) {
                parents[find(set)] = find(shared.try_emplace(key, set).first->second);
            };
            parts.push_back({set, slab > low, slab < high});
            for (std::size_t i = 0; i < 3; ++i) {
                const std::size_t next = (i + 1) % 3;
                const auto [first, last] = std::minmax(slabs[i], slabs[next]);
                if (slabs[i] == slab) {
                    join(std::pair(slab, std::pair(t[i], t[i])));
                }
                if (first <= slab && slab <= last) {
                    join(std::pair(slab, std::pair(std::minmax(t[i], t[next]))));
                }
            }
        }
    }
    std::vector<int> meets(parents.size(), 0);
    for (const Part& part : parts) {
        meets[find(part.set)] |= (part.meets_below ? 1 : 0) | (part.meets_above ? 2 : 0);
    }
    std::array<std::size_t, 3> counts{};
    for (std::size_t set = 0; set < parents.size(); ++set) {
        if (find(set) == set && meets[set] != 3) {
            ++counts[static_cast<std::size_t>(meets[set])];
        }
    }
    return counts;
}

Ledger booked(const shapes::Soup& soup, const SliceResult& result) {
    Ledger books = value_of(audits::ledger_of(result, view_of(soup)));
    CHECK(books.triangles == soup.size() / 9);
    CHECK(books.cut + books.between + books.degenerate == books.triangles);
    CHECK(books.cut == result.info.crossed);
    CHECK(books.degenerate == result.info.degenerate);
    LedgerSlab all;
    for (const LedgerSlab& slab : books.slabs) {
        all.triangles += slab.triangles;
        all.shells += slab.shells;
        all.peaks += slab.peaks;
        all.pits += slab.pits;
        CHECK(slab.triangles + slab.shells + slab.peaks + slab.pits > 0);
    }
    CHECK(all.triangles == books.between);
    CHECK(all.shells == books.shells.count);
    CHECK(all.peaks == books.peaks.count);
    CHECK(all.pits == books.pits.count);
    CHECK(books.shells.triangles + books.peaks.triangles + books.pits.triangles <= books.between);
    CHECK(books.pieces.size() == all.shells + all.peaks + all.pits);
    return books;
}

TEST_CASE("ledger: pieces agree with their definition", "[engine][ledger]") {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const int count = 1 + static_cast<int>(seed % 25);
        const shapes::Soup soup =
            seed % 2 == 0 ? shapes::random_soup(seed, 2 * count, 12) : shapes::random_tetrahedra(seed, count, 9 + seed % 8);
        for (const auto& heights : {std::vector<double>{2, 3, 4, 7, 8}, {5}, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}}) {
            INFO("seed " << seed);
            const SliceResult result = sliced(soup, at_heights(heights));
            const Ledger books = booked(soup, result);
            CHECK(pieces_of(soup, result) ==
                  std::array<std::size_t, 3>{books.shells.count, books.peaks.count, books.pits.count});
        }
    }
}

VolumeCertificate certified(const shapes::Soup& soup, const SliceResult& result, int threads = 1) {
    return value_of(audits::volume_of(result, view_of(soup), {.threads = threads}));
}

/// A ball with a cavity, for slices of many layers.
shapes::Soup hollow() {
    return shapes::joined({shapes::octasphere({0, 0, 0}, 10, 3), shapes::flipped(shapes::octasphere({1, 2, 1}, 5, 2))});
}

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

/// The volumes below, between and above the planes, by Gauss's theorem from the facets' walls.
std::vector<long double> volumes_of(std::span<const oracle::Triangle> triangles, const SliceResult& result) {
    std::vector<long double> slabs(result.size() + 1);
    for (const oracle::Triangle& t : triangles) {
        Piece rest;
        for (const GridVertex v : t) {
            rest.push_back({static_cast<long double>(v.x), static_cast<long double>(v.y), static_cast<long double>(v.z)});
        }
        for (std::size_t i = 0; i < slabs.size() && !rest.empty(); ++i) {
            const bool last = i == result.size();
            const auto plane = static_cast<long double>(last ? 0 : result.layers[i].plane.z());
            const Piece piece = last ? std::exchange(rest, {}) : clipped(rest, plane, false);
            for (std::size_t p = 1; p + 1 < piece.size(); ++p) {
                const Corner& a = piece[0];
                const Corner& b = piece[p];
                const Corner& c = piece[p + 1];
                slabs[i] += (a.x + b.x + c.x) / 6 * ((b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y));
            }
            rest = clipped(rest, plane, true);
        }
    }
    return slabs;
}

TEST_CASE("certificate: random soups never get a wrong verdict", "[engine][certificate]") {
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        INFO("seed " << seed);
        const shapes::Soup closed = shapes::random_tetrahedra(seed, 1 + static_cast<int>(seed % 30), 3 + seed % 6);
        CHECK(certified(closed, sliced(closed, at_heights({1, 2, 3, 4, 5, 6, 7}))).verdict == VolumeVerdict::holds);
        CHECK(certified(closed, sliced(closed, uniform(0.37))).verdict == VolumeVerdict::holds);
        const shapes::Soup open = shapes::random_soup(seed, 1 + static_cast<int>(seed % 30), 3 + seed % 6);
        const auto counts = check(view_of(open), {.frame = {.grid_mm = coarse_unit_mm}, .counts_only = true});
        const VolumeVerdict verdict = certified(open, sliced(open, at_heights({1, 2, 3, 4}))).verdict;
        CHECK((verdict == VolumeVerdict::open_mesh) == !counts.value().closed);
    }
}

TEST_CASE("certificate: where solid is not what the mesh encloses both areas are stated", "[engine][certificate]") {
    const SliceOptions options{.heights_mm = {{5, 15, 25}}, .region = {.fill_rule = FillRule::non_zero}};
    const auto stated = [&](const shapes::Soup& soup) { return words_for(certified(soup, sliced(soup, options))); };
    const std::string head =
        "not certified: solid is not what the mesh encloses, as shells overlap or are turned inwards: in ";
    CHECK(stated(shapes::joined({shapes::box({0, 0, 0}, {20, 20, 30}), shapes::box({0, 0, 10}, {20, 20, 30})})) ==
          head + "2 layers it encloses 1600 mm2 by its facets, and 800 mm2 are solid");
    CHECK(stated(shapes::joined(
              {shapes::box({0, 0, 0}, {20, 20, 30}), shapes::flipped(shapes::box({30, 0, 0}, {40, 10, 10}))})) ==
          head + "1 layer it encloses 300 mm2 by its facets, and 500 mm2 are solid");
}

TEST_CASE("certificate: a damaged result is rejected, and the layer is named", "[engine][certificate]") {
    const shapes::Soup mesh = hollow();
    const std::tuple<const char*, std::uint64_t, std::function<void(SliceResult&)>> damages[] = {
        {"a layer's plane moved", 20,
         [](SliceResult& r) { r.layers[20].plane = PlaneHeight(r.layers[20].plane.z() + 2000); }},
        {"a point moved", 12,
         [](SliceResult& r) { r.points[r.contours[r.layers[12].first_contour].first_point + 2].x += 1000; }},
        {"an outer called a hole", 50, [](SliceResult& r) { r.contours[r.layers[50].first_contour].role = Role::hole; }},
    };
    for (const auto& [what, layer, damage] : damages) {
        SliceResult result = sliced(mesh, uniform(0.2));
        REQUIRE(certified(mesh, result).verdict == VolumeVerdict::holds);
        REQUIRE(result.layers[50].contour_count == 2);
        damage(result);
        const VolumeCertificate certificate = certified(mesh, result);
        INFO(what);
        CHECK(certificate.verdict == VolumeVerdict::areas_differ);
        CHECK((certificate.worst_layer == layer || certificate.worst_layer == layer + 1));
        CHECK(certificate.worst_difference_mm2 > certificate.worst_allowed_mm2);
        CHECK(certificate.slabs_mm3 == Approx(certificate.mesh_mm3).epsilon(1e-12));
    }
}

TEST_CASE("certificate: the result of another mesh is rejected", "[engine][certificate]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    const SliceResult result = sliced(ball, uniform(0.2));
    shapes::Soup higher = ball;  // at its top, which is one vertex
    for (std::size_t i = 2; i < higher.size(); i += 3) {
        higher[i] += higher[i] == 10 ? 0.01 : 0;
    }
    const VolumeCertificate moved = certified(higher, result);
    CHECK(moved.verdict == VolumeVerdict::areas_differ);
    CHECK(moved.worst_layer > 90);
    // One triangle fewer: the number of triangles differs.
    const shapes::Soup fewer(ball.begin() + 9, ball.end());
    CHECK(code_of(audits::volume_of(result, view_of(fewer))) == ErrorCode::invalid_argument);
    // The same number of triangles, but one is there twice.
    shapes::Soup doubled = ball;
    std::copy_n(doubled.begin() + 9, 9, doubled.begin());
    CHECK(certified(doubled, result).verdict == VolumeVerdict::open_mesh);
}

TEST_CASE("certificate: malformed input is an error", "[engine][certificate]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 1);
    const std::function<void(SliceResult&)> damages[] = {
        [](SliceResult& r) { std::swap(r.layers[3].plane, r.layers[4].plane); },
        [](SliceResult& r) { r.layers[3].contour_count = ~std::uint64_t{0}; },
        [](SliceResult& r) { r.contours[3].first_point = ~std::uint64_t{0}; },
        [](SliceResult& r) { std::swap(r.layers[3].first_contour, r.layers[4].first_contour); },
        [](SliceResult& r) { --r.layers[3].contour_count; },
        [](SliceResult& r) { r.info.grid_mm = 1e-12; },
    };
    for (const auto& damage : damages) {
        SliceResult result = sliced(ball, uniform(0.5));
        damage(result);
        CHECK(code_of(audits::volume_of(result, view_of(ball))) == ErrorCode::invalid_argument);
        CHECK(code_of(audits::ledger_of(result, view_of(ball))) == ErrorCode::invalid_argument);
    }
    const SliceResult result = sliced(ball, uniform(0.5));
    shapes::Indexed lying = shapes::indexed(ball);
    lying.indices[7] = 1000;
    CHECK(code_of(audits::volume_of(result, lying.view())) == ErrorCode::invalid_argument);
}

TEST_CASE("the volumes of slabs are those of the facets between planes, and sum to the mesh's, whatever its shells do",
          "[engine][volume][certificate]") {
    using models::Shape;
    constexpr std::uint64_t triangles = 160 * rounds(125);
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 2);
    const shapes::Soup box = shapes::box({1, 1, 1}, {4, 4, 4});
    const shapes::Soup meshes[] = {
        hollow(),
        shapes::moved(shapes::joined({ball, shapes::moved(ball, {3, 4, 5})}), {900, -900, 900}),  // far away
        shapes::flipped(ball),
        shapes::joined({box, shapes::box({4, 4, 1}, {8, 8, 4}), box}),  // an edge in common
        shapes::scaled(ball, {100, 100, 0.001}),
        shapes::scaled(ball, {0.0001, 0.0001, 100}),
        shapes::scaled(ball, {90000, 90000, 90000}),
        generated(Shape::gyroid, triangles),
        generated(Shape::bone, triangles),
        generated(Shape::torus, triangles)};
    for (const shapes::Soup& mesh : meshes) {
        const Box bounds = value_of(check(view_of(mesh), {.counts_only = true})).box;
        const double low = bounds.min_mm[2];
        const double high = bounds.max_mm[2];
        const double height = high - low;
        for (const SliceOptions& options :
             {uniform(height / 7.3), uniform(height / 80), at_heights({}, 0),
              at_heights({low - 1000 * height, low - height / 8, low + height / 3, high + height / 9}, 0)}) {
            const SliceResult result = sliced(mesh, options);
            const std::vector<oracle::Triangle> facets = oracle::quantise(mesh, result.info.grid_mm);
            const std::vector<long double> slabs = volumes_of(facets, result);
            const long double cube_mm3 = std::pow(static_cast<long double>(result.info.grid_mm), 3);
            const VolumeCertificate certificate = certified(mesh, result);
            CHECK(certificate.verdict == VolumeVerdict::holds);
            REQUIRE(certificate.slab_mm3.size() == slabs.size());
            const long double scale = 1e-12L * std::accumulate(slabs.begin(), slabs.end(), 0.0L,
                                                               [](auto sum, auto slab) { return sum + std::abs(slab); });
            for (std::size_t i = 0; i < slabs.size(); ++i) {
                INFO("mesh " << &mesh - meshes << ", slab " << i << " of " << slabs.size());
                REQUIRE(std::abs(slabs[i] * cube_mm3 - certificate.slab_mm3[i]) <= scale * cube_mm3);
            }
            const long double sum = std::accumulate(slabs.begin(), slabs.end(), 0.0L);
            CHECK(std::abs(sum * cube_mm3 - certificate.mesh_mm3) <= scale * cube_mm3);
        }
    }
}

}  // namespace
