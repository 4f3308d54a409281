// The volume certificate. It holds for every result that the engine makes from a closed mesh. It reports where it does not
// apply, and rejects damaged results. The volumes of its slabs are those of the facets, cut at the planes one by one.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "oracle/oracle.hpp"

using lamella::SliceResult;
using lamella::VolumeCertificate;
using lamella::VolumeVerdict;

namespace {

VolumeCertificate certified(const shapes::Soup& soup, const SliceResult& result, int threads = 1) {
    return value_of(audits::volume_of(result, view_of(soup), {.threads = threads}));
}

bool same(const VolumeCertificate& a, const VolumeCertificate& b) {
    return a.verdict == b.verdict && a.mesh_mm3 == b.mesh_mm3 && a.slabs_mm3 == b.slabs_mm3 && a.slab_mm3 == b.slab_mm3 &&
           a.worst_layer == b.worst_layer && a.worst_difference_mm2 == b.worst_difference_mm2 &&
           a.worst_allowed_mm2 == b.worst_allowed_mm2;
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
        for (const lamella::GridVertex v : t) {
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

/// Six times the volume, exactly.
oracle::Int128 six_volumes(std::span<const oracle::Triangle> triangles) {
    oracle::Int128 sum = 0;
    for (const oracle::Triangle& t : triangles) {
        const auto minor = [&](std::size_t i) {
            const lamella::GridVertex u = t[(i + 1) % 3];
            const lamella::GridVertex v = t[(i + 2) % 3];
            return oracle::Int128{t[i].z} * (std::int64_t{u.x} * v.y - std::int64_t{u.y} * v.x);
        };
        sum += minor(0) + minor(1) + minor(2);
    }
    return sum;
}

}  // namespace

TEST_CASE("certificate: one slab holds the whole volume if no plane meets the mesh", "[engine][certificate]") {
    const shapes::Soup cone = shapes::joined({shapes::octasphere({5, 5, 5}, 4, 0)});
    const VolumeCertificate none = certified(cone, sliced(cone, at_heights({})));
    CHECK(none.verdict == VolumeVerdict::holds);
    REQUIRE(none.slab_mm3.size() == 1);
    CHECK(none.slab_mm3[0] == Approx(256.0 / 3).epsilon(1e-12));
    const VolumeCertificate beside = certified(cone, sliced(cone, at_heights({-90000, -4, 20, 1e8})));
    CHECK(beside.verdict == VolumeVerdict::holds);
    CHECK(beside.slab_mm3 == std::vector<double>{0, 0, beside.slabs_mm3, 0, 0});
}

TEST_CASE("certificate: it holds for shells that overlap, cancel, are inverted or touch", "[engine][certificate]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 2);
    const shapes::Soup box = shapes::box({1, 1, 1}, {4, 4, 4});
    const shapes::Soup meshes[] = {
        hollow(),
        shapes::joined({ball, shapes::moved(ball, {3, 4, 5})}),
        shapes::flipped(ball),
        shapes::joined({ball, shapes::flipped(ball)}),
        shapes::joined({ball, shapes::flipped(shapes::moved(ball, {7, 0, 0.1}))}),
        shapes::joined({box, shapes::box({4, 4, 1}, {8, 8, 4}), box}),
        shapes::scaled(ball, {100, 100, 0.001}),
        shapes::scaled(ball, {0.0001, 0.0001, 100}),
        shapes::moved(ball, {1000, -1000, 1000}),
        shapes::scaled(ball, {90000, 90000, 90000}),
    };
    for (const shapes::Soup& mesh : meshes) {
        double low = mesh[2];
        double high = mesh[2];
        for (std::size_t i = 2; i < mesh.size(); i += 3) {
            low = std::min(low, mesh[i]);
            high = std::max(high, mesh[i]);
        }
        for (const double layers : {7.3, 150.0}) {
            const SliceResult result = sliced(mesh, uniform((high - low) / layers));
            const VolumeCertificate certificate = certified(mesh, result);
            INFO(&mesh - meshes << ", " << layers << " layers: " << certificate.mesh_mm3 << " " << certificate.slabs_mm3);
            CHECK(certificate.verdict == VolumeVerdict::holds);
            // Where shells nearly cancel, the remaining volume may be rounding error only.
            CHECK((&mesh == &meshes[4] ||
                   std::abs(certificate.slabs_mm3 - certificate.mesh_mm3) <= 1e-12 * std::abs(certificate.mesh_mm3)));
        }
    }
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

TEST_CASE("certificate: open meshes, fill rules and closed gaps are not certified", "[engine][certificate]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 2);
    const shapes::Soup open(ball.begin() + 9, ball.end());
    const VolumeCertificate certificate = certified(open, sliced(open, uniform(0.5)));
    CHECK(certificate.verdict == VolumeVerdict::open_mesh);
    CHECK_FALSE(certificate.applies());
    CHECK(std::isnan(certificate.mesh_mm3));
    CHECK(certificate.open.layers > 0);
    // A flipped face makes its edges unbalanced.
    shapes::Soup turned = ball;
    std::swap_ranges(turned.begin(), turned.begin() + 3, turned.begin() + 3);
    CHECK(certified(turned, sliced(turned, uniform(0.5))).verdict == VolumeVerdict::open_mesh);
    lamella::SliceOptions options = uniform(0.5);
    options.region.fill_rule = lamella::FillRule::outermost;
    CHECK(certified(ball, sliced(ball, options)).verdict == VolumeVerdict::not_as_walked);
    options.region = {.fill_rule = lamella::FillRule::non_zero, .offset_mm = 0.1};
    CHECK(certified(ball, sliced(ball, options)).verdict == VolumeVerdict::not_as_walked);
}

TEST_CASE("certificate: by the rule non-zero it holds as by contours where shells lie apart or bound cavities",
          "[engine][certificate]") {
    lamella::SliceOptions options = uniform(0.37);
    const VolumeCertificate walked = certified(hollow(), sliced(hollow(), options));
    options.region.fill_rule = lamella::FillRule::non_zero;
    CHECK(same(certified(hollow(), sliced(hollow(), options)), walked));
    // A pocket that touches a face from inside takes away what it encloses, as the mesh does.
    const shapes::Soup pocket =
        shapes::joined({shapes::box({0, 0, 0}, {10, 10, 10}), shapes::flipped(shapes::box({0, 3, 1}, {5, 7, 9}))});
    lamella::SliceOptions planes = at_heights({0.5, 5});
    planes.region.fill_rule = lamella::FillRule::non_zero;
    const lamella::SliceResult cut = sliced(pocket, planes);
    CHECK(cut[1].area_mm2() == 80);
    CHECK(certified(pocket, cut).verdict == VolumeVerdict::holds);
}

TEST_CASE("certificate: where solid is not what the mesh encloses both areas are stated", "[engine][certificate]") {
    lamella::SliceOptions options = at_heights({5, 15, 25});
    options.region.fill_rule = lamella::FillRule::non_zero;
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
    struct Damage {
        const char* what;
        std::uint64_t layer;
        std::function<void(SliceResult&)> apply;
    };
    const Damage damages[] = {
        {"a contour dropped", 50, [](SliceResult& r) { --r.layers[50].contour_count; }},
        {"one contour too many", 49, [](SliceResult& r) { ++r.layers[49].contour_count; }},
        {"layers swapped", 30,
         [](SliceResult& r) {
             std::swap(r.layers[30].first_contour, r.layers[31].first_contour);
             std::swap(r.layers[30].contour_count, r.layers[31].contour_count);
         }},
        {"a layer's plane moved", 20,
         [](SliceResult& r) { r.layers[20].plane = lamella::PlaneHeight(r.layers[20].plane.z() + 2000); }},
        {"a point removed", 60, [](SliceResult& r) { --r.contours[r.layers[60].first_contour].point_count; }},
        {"a point moved", 12,
         [](SliceResult& r) { r.points[r.contours[r.layers[12].first_contour].first_point + 2].x += 1000; }},
        {"an outer called a hole", 50,
         [](SliceResult& r) { r.contours[r.layers[50].first_contour].role = lamella::Role::hole; }},
    };
    for (const Damage& damage : damages) {
        SliceResult result = sliced(mesh, uniform(0.2));
        REQUIRE(certified(mesh, result).verdict == VolumeVerdict::holds);
        REQUIRE(result.layers[50].contour_count == 2);
        damage.apply(result);
        const VolumeCertificate certificate = certified(mesh, result);
        INFO(damage.what);
        CHECK(certificate.verdict == VolumeVerdict::areas_differ);
        CHECK((certificate.worst_layer == damage.layer || certificate.worst_layer == damage.layer + 1));
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
    CHECK(code_of(audits::volume_of(result, view_of(fewer))) == lamella::ErrorCode::invalid_argument);
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
        [](SliceResult& r) { r.layers[3].first_contour = ~std::uint64_t{0}; },
        [](SliceResult& r) { r.contours[3].point_count = ~std::uint32_t{0}; },
        [](SliceResult& r) { r.contours[3].first_point = ~std::uint64_t{0}; },
        [](SliceResult& r) { r.info.grid_mm = 1e-12; },
    };
    for (const auto& damage : damages) {
        SliceResult result = sliced(ball, uniform(0.5));
        damage(result);
        CHECK(code_of(audits::volume_of(result, view_of(ball))) == lamella::ErrorCode::invalid_argument);
        CHECK(code_of(audits::ledger_of(result, view_of(ball))) == lamella::ErrorCode::invalid_argument);
    }
    const SliceResult result = sliced(ball, uniform(0.5));
    shapes::Indexed lying = shapes::indexed(ball);
    lying.indices[7] = 1000;
    CHECK(code_of(audits::volume_of(result, lying.view())) == lamella::ErrorCode::invalid_argument);
}

TEST_CASE("the volumes of slabs are those of the facets between planes, and sum to the mesh's", "[engine][volume]") {
    using lamella::models::Shape;
    constexpr std::uint64_t triangles = 160 * rounds(125);
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    const shapes::Soup meshes[] = {
        hollow(),
        shapes::moved(shapes::joined({ball, shapes::moved(ball, {3, 4, 5})}), {900, -900, 900}),  // far away
        shapes::joined({shapes::box({0, 0, 0}, {4, 4, 4}), shapes::box({4, 4, 0}, {8, 8, 4})}),   // an edge in common
        generated(Shape::gyroid, triangles),
        generated(Shape::bone, triangles),
        generated(Shape::torus, triangles)};
    for (const shapes::Soup& mesh : meshes) {
        const SliceResult result = sliced(mesh, uniform(0.25));
        const std::vector<oracle::Triangle> facets = oracle::quantise(mesh, result.info.grid_mm);
        const std::vector<long double> slabs = volumes_of(facets, result);
        const long double volume = static_cast<long double>(six_volumes(facets)) / 6;
        const long double cube_mm3 = std::pow(static_cast<long double>(result.info.grid_mm), 3);
        const VolumeCertificate certificate = certified(mesh, result);
        CHECK(certificate.verdict == VolumeVerdict::holds);
        REQUIRE(certificate.slab_mm3.size() == slabs.size());
        long double sum = 0;
        for (std::size_t i = 0; i < slabs.size(); ++i) {
            INFO("mesh " << &mesh - meshes << ", slab " << i);
            sum += slabs[i];
            REQUIRE(std::abs(slabs[i] * cube_mm3 - certificate.slab_mm3[i]) <= 1e-12L * volume * cube_mm3);
        }
        CHECK(std::abs(sum - volume) <= 1e-12L * std::abs(volume));
    }
}
