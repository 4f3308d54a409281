// Where contour edges come from, compared with each triangle cut by itself.
#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/origin_oracle.hpp"
#include "engine/rounds.hpp"
#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"

using lamella::ContourForm;
using lamella::PointOrigin;
using lamella::SliceOptions;
using lamella::SliceResult;
using origin_oracle::traced;
using origin_oracle::Triangles;
using origin_oracle::with_origins;

namespace {

/// Every triangle that a plane cuts is named by its contour edge, and by no other.
void check_against_oracle(const shapes::Soup& soup, const SliceResult& result) {
    const Triangles triangles(soup, result);
    for (const lamella::LayerView layer : result) {
        INFO("plane " << layer.plane.z());
        REQUIRE(triangles.edges_of(layer) == triangles.cuts_at(layer.plane));
    }
}

std::vector<PointOrigin> all(const SliceResult& result) {
    return {result.origins.begin(), result.origins.end()};
}

/// Closed and open ones, with edges of all kinds, repeated triangles, and parts inside out.
std::map<std::string, shapes::Soup> difficult_meshes() {
    std::map<std::string, shapes::Soup> meshes = shape_cases::meshes();
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 2);
    const shapes::Soup tangle = shapes::random_tetrahedra(3, 6, 4);
    const shapes::Soup soup = shapes::random_soup(7, 40, 4);
    meshes["repeated"] = shapes::joined({ball, shapes::shuffled(ball, 1), shapes::flipped(ball), ball});
    meshes["repeated tangle"] = shapes::joined({tangle, shapes::shuffled(tangle, 2), shapes::flipped(tangle), tangle});
    meshes["repeated soup"] = shapes::joined({soup, shapes::shuffled(soup, 2), shapes::flipped(soup)});
    meshes["inside out"] = shapes::flipped(ball);
    meshes["inside out within"] = shapes::joined({ball, shapes::flipped(shapes::scaled(ball, {0.5, 0.5, 0.5}))});
    return meshes;
}

}  // namespace

TEST_CASE("each contour edge names the triangle that it cuts, and the edges at its ends, in any order of triangles",
          "[engine][origins]") {
    for (const auto& [mesh_name, mesh] : difficult_meshes()) {
        for (const auto& [plan_name, options] : shape_cases::plans(mesh)) {
            INFO(mesh_name << ", " << plan_name);
            check_against_oracle(mesh, traced(mesh, options));
        }
        INFO(mesh_name << ", shuffled, in one band");
        const shapes::Soup shuffled = shapes::shuffled(mesh, 4);
        check_against_oracle(shuffled, traced(shuffled, uniform(0.125), {.band_planes = 1000}));
    }
}

TEST_CASE("contour edges of random triangles name them", "[engine][origins][random]") {
    const auto seed = GENERATE(range(1U, 1 + rounds(149)));
    for (const ContourForm form : {ContourForm::swept, ContourForm::assembled}) {
        for (const std::uint64_t range : {2U, 3U, 8U}) {
            const SliceOptions options = through_quarters(range);
            const lamella::Tuning tuning{.form = form};
            const shapes::Soup soup = shapes::random_soup(seed, 30, range);
            const shapes::Soup solids = shapes::random_tetrahedra(seed, 6, range);
            INFO("seed " << seed << ", range " << range << ", assembled " << (form == ContourForm::assembled));
            check_against_oracle(soup, traced(soup, options, tuning));
            check_against_oracle(solids, traced(solids, options, tuning));
        }
    }
}

TEST_CASE("contours equal in every point come in the order of their triangles", "[engine][origins]") {
    // Two tetrahedra with a vertical edge in common. Near their lowest vertex all their corners round to the same points.
    const auto tetrahedron = [](double size) {
        return shapes::tetrahedron({0, 0, 0}, {size, 0, 4}, {0, 0, 4}, {0, size, 4});
    };
    for (const auto& [first, second] : {std::pair(3, 4), std::pair(4, 3)}) {
        const shapes::Soup both = shapes::joined({tetrahedron(first), tetrahedron(second)});
        for (const ContourForm form : {ContourForm::swept, ContourForm::assembled}) {
            const SliceResult result = traced(both, at_heights({1}), {.form = form});
            REQUIRE(result.contours.size() == 2);
            REQUIRE(std::equal(result.points.begin(), result.points.begin() + 3, result.points.begin() + 3));
            CHECK(std::all_of(result.origins.begin(), result.origins.begin() + 3,
                              [](const PointOrigin& origin) { return origin.triangle < 4; }));
        }
    }
}

TEST_CASE("an open polyline ends at the edge of its last triangle", "[engine][origins][repair]") {
    // The front side lacks its two triangles.
    const shapes::Soup open = shapes::without(shapes::box({0, 0, 0}, {4, 4, 4}), 4, 2);
    const SliceResult result = traced(open, at_heights({2}));
    REQUIRE(result.contours[0].role == lamella::Role::open);
    check_against_oracle(open, result);
    const PointOrigin& last = result.origins[result.origins.size() - 2];
    CHECK(result.origins[result.origins.size() - 1] == PointOrigin{last.triangle, 0, last.end_edge, lamella::no_edge});
}

TEST_CASE("joined gaps of random triangles leave the origins of all others", "[engine][origins][repair][random]") {
    const auto seed = GENERATE(range(1U, 1 + rounds(99)));
    const shapes::Soup soup = shapes::random_soup(seed, 30, 5);
    SliceOptions options = through_quarters(5);
    options.stitch_mm = 0.75;
    const SliceResult result = traced(soup, options);
    check_against_oracle(soup, result);
    const auto gaps = static_cast<std::size_t>(std::count_if(result.stitches.begin(), result.stitches.end(),
                                                             [](const lamella::Stitch& gap) { return gap.from != gap.to; }));
    CHECK(static_cast<std::size_t>(std::count(result.origins.begin(), result.origins.end(), PointOrigin())) == gaps);
}

TEST_CASE("a wide plane says where its edges come from", "[engine][origins][wide][threads]") {
    // The box is cut by the first plane alone, so that the prism's records are not those with the first numbers.
    const shapes::Soup prism = shapes::joined({shapes::box({0, 0, 0}, {4, 4, 2}), shapes::prism(1 << 15, 900, 4)});
    const SliceOptions options = with_origins(uniform(2));
    const std::vector<PointOrigin> expected = all(sliced(prism, options, {.threads = 1}, {.form = ContourForm::assembled}));
    const SliceResult result = sliced(prism, options, {.threads = 3});
    CHECK(result.layers[1].segments >= std::size_t{1} << 18);
    CHECK(all(result) == expected);
    CHECK(audits::structure_of(result, view_of(prism)).ok());
}

TEST_CASE("origins count towards the memory limit", "[engine][origins]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 2);
    const SliceOptions options = uniform(0.5);
    const SliceResult result = sliced(ball, options);
    lamella::Context context;
    context.memory_limit_bytes = result.info.segments * sizeof(lamella::Point) +
                                 result.layers.size() * (sizeof(lamella::Layer) + sizeof(lamella::Contour));
    CHECK(slice(view_of(ball), options, context).ok());
    CHECK(failure_of(view_of(ball), with_origins(options), context).code == lamella::ErrorCode::result_too_large);
    context.memory_limit_bytes += result.info.segments * sizeof(PointOrigin);
    CHECK(slice(view_of(ball), with_origins(options), context).ok());
}

TEST_CASE("an audit of the structure finds origins that do not suit the result or the mesh", "[engine][origins]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const lamella::MeshView mesh = view_of(box);
    SliceResult result = traced(box, at_heights({2, 3}));
    const std::string here = "layer 0, contour 0, point 0: ";
    const auto complaint = [&](const std::function<void(PointOrigin&)>& damage) {
        const PointOrigin right = result.origins[0];
        damage(result.origins[0]);
        const lamella::Status status = audits::structure_of(result, mesh);
        result.origins[0] = right;
        return status ? std::string() : status.error().message;
    };
    using Origin = PointOrigin;
    REQUIRE(result.origins[0] == Origin{5, 0, 2, 0});
    CHECK(complaint([](Origin&) {}).empty());
    // Seen without the mesh.
    CHECK(complaint([](Origin& origin) { origin.triangle = lamella::no_triangle; }) ==
          "contour 0, point 0: an origin without a triangle, yet with an edge or a part");
    CHECK(complaint([](Origin& origin) { origin.edge = 4; }) ==
          "contour 0, point 0: the origin names an edge that no triangle has");
    CHECK(complaint([](Origin& origin) { origin.end_edge = 2; }) ==
          "contour 0, point 0: the contour edge begins and ends on the same edge of its triangle");
    CHECK(complaint([](Origin& origin) { origin.triangle = 12; }) ==
          "contour 0, point 0: the origin's triangle is not in the mesh");
    CHECK(complaint([](Origin& origin) { origin.part = 1; }) ==
          "contour 0, point 0: the origin's part is not the contour's");
    // Seen by the mesh.
    CHECK(complaint([](Origin& origin) { origin = {}; }) ==
          here + "no origin, though nothing was made, joined or simplified here");
    CHECK(complaint([](Origin& origin) { origin.triangle = 0; }) == here + "the plane does not cut the origin's triangle");
    CHECK(complaint([](Origin& origin) { origin.triangle = 9; }) ==
          here + "the point does not lie on the edge that its origin names");
    CHECK(complaint([](Origin& origin) { origin.edge = 1; }) ==
          here + "the point does not lie on the edge that its origin names");
    CHECK(complaint([](Origin& origin) { origin.end_edge = 1; }) ==
          here + "the contour edge does not end on the edge that its origin names");
    CHECK(complaint([](Origin& origin) {
              origin = {9, 0, lamella::no_edge, lamella::no_edge};
          }) == here + "the contour edge does not lie in the origin's triangle");
    // A mesh of which one facet looks the other way.
    shapes::Soup back = box;
    const shapes::Soup flipped = shapes::flipped(box);
    std::copy_n(flipped.begin() + 9 * 5, 9, back.begin() + 9 * 5);
    const PointOrigin right = std::exchange(result.origins[0], Origin{5, 0, 0, 2});
    result.origins[8] = result.origins[0];
    CHECK(audits::structure_of(result, view_of(back)).error().message == here + "the contour edge runs against its facet");
    result.origins[0] = result.origins[8] = right;
    CHECK(audits::structure_of(result, mesh).ok());

    const shapes::Soup two = shapes::joined({box, box});
    CHECK(audits::structure_of(result, view_of(two)).error().message == "the result is not of this mesh");
    CHECK(audits::structure_of(result, std::vector<lamella::Part>(2, {.mesh = mesh})).error().message ==
          "the result is not of so many parts");
    result.origins.set_size(15);
    CHECK(audits::structure_of(result).error().message == "there are not as many origins as points");
}
