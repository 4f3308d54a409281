// What must stay the same, or change in a known way, if the mesh is moved, mirrored or turned, or if planes are sliced in
// parts.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <tuple>

#include <catch2/catch.hpp>

#include "engine/rounds.hpp"
#include "engine/slicing.hpp"
#include "engine/vertex_heights.hpp"
#include "models/models.hpp"
#include "rings.hpp"

using lamella::Contour;
using lamella::Layer;
using lamella::Point;
using lamella::Role;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::models::Shape;

namespace {

constexpr std::uint64_t model_triangles = 160 * rounds(125);

constexpr double unit_mm = lamella::default_unit_mm;
constexpr double layer_mm = 0.25;

/// Rounds every number to the even grid, so that moving, mirroring and turning round nothing.
shapes::Soup on_grid(shapes::Soup soup) {
    for (double& number : soup) {
        number = std::nearbyint(number / (2 * unit_mm)) * (2 * unit_mm);
    }
    return soup;
}

/// Closed meshes, and one that is not closed.
const std::map<std::string, shapes::Soup>& meshes() {
    static const std::map<std::string, shapes::Soup> all = [] {
        const shapes::Soup ball = on_grid(shapes::octasphere({0.3, 0.2, 0.1}, 10, 3));
        const shapes::Soup cavity = on_grid(shapes::flipped(shapes::octasphere({1, 2, 1}, 5, 2)));
        const shapes::Soup boxes =
            shapes::joined({shapes::box({20, 0, 0}, {24, 4, 4}), shapes::box({24, 4, 0}, {28, 8, 4})});
        shapes::Soup torn = ball;
        torn.resize(torn.size() - 9 * std::size_t{40});
        return std::map<std::string, shapes::Soup>{
            {"hollow ball", shapes::joined({ball, cavity})},
            {"boxes that share an edge", boxes},
            {"crossing balls", shapes::joined({ball, shapes::moved(ball, {3, 4, 5})})},
            {"torn ball", torn},
            {"gyroid", on_grid(generated(Shape::gyroid, model_triangles))},
            {"bone", on_grid(generated(Shape::bone, model_triangles))}};
    }();
    return all;
}

/// A contour without its position in the layer and its start. Equal points give equal areas and perimeters.
struct Outline {
    Role role;
    int orientation;
    std::uint32_t segments;
    std::pair<std::int64_t, std::uint64_t> twice_area;
    std::vector<Point> points;
    std::vector<Point> around;  ///< points of the parent
    friend auto operator<=>(const Outline&, const Outline&) = default;
};

/// How the mesh, and so its contours, moved.
struct Motion {
    std::function<Point(Point)> map = [](Point p) { return p; };
    bool mirrors = false;  ///< reverses contours
    bool parents = true;   ///< whether parents must stay the same too
};

std::vector<Point> moved(std::span<const Point> points, bool closed, const Motion& motion) {
    std::vector<Point> all(points.size());
    std::transform(points.begin(), points.end(), all.begin(), motion.map);
    if (motion.mirrors) {
        std::reverse(all.begin(), all.end());
    }
    return closed ? rings::from_smallest(all) : all;
}

/// The contours of a layer after `motion`.
std::vector<Outline> outlines(const SliceResult& result, const Layer& layer, const Motion& motion = {}) {
    std::vector<Outline> all;
    for (const Contour& contour : result.contours_of(layer)) {
        const auto points_of = [&](const Contour& c) { return moved(result.points_of(c), c.role != Role::open, motion); };
        Outline outline{contour.role,       contour.orientation,
                        contour.segments,   {contour.twice_area.high, contour.twice_area.low},
                        points_of(contour), {}};
        if (contour.parent >= 0 && motion.parents) {
            outline.around = points_of(result.contours[static_cast<std::size_t>(contour.parent)]);
        }
        all.push_back(std::move(outline));
    }
    std::sort(all.begin(), all.end());
    return all;
}

void check_carried_over(const SliceResult& from, const SliceResult& to, const Motion& motion) {
    Motion none;
    none.parents = motion.parents;
    REQUIRE(from.layers.size() == to.layers.size());
    std::size_t equal = 0;
    for (std::size_t l = 0; l < from.layers.size(); ++l) {
        equal += static_cast<std::size_t>(outlines(from, from.layers[l], motion) == outlines(to, to.layers[l], none));
    }
    CHECK(equal == from.layers.size());
}

/// Corners (x, y, z) become (xx x + xy y, yx x + yy y, z).
shapes::Soup turned(shapes::Soup soup, double xx, double xy, double yx, double yy) {
    for (std::size_t i = 0; i < soup.size(); i += 3) {
        const double x = soup[i];
        const double y = soup[i + 1];
        soup[i] = xx * x + xy * y;
        soup[i + 1] = yx * x + yy * y;
    }
    return soup;
}

SliceOptions at_explicit(std::vector<double> heights) {
    SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{std::move(heights)};
    options.unit_mm = unit_mm;
    return options;
}

/// Slices at the heights whose index `takes` accepts, and requires the same layers as in `whole`.
void check_part(const shapes::Soup& mesh, const std::vector<double>& heights, const SliceResult& whole,
                const std::function<bool(std::size_t)>& takes) {
    std::vector<double> part;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < heights.size(); ++i) {
        if (takes(i)) {
            part.push_back(heights[i]);
            places.push_back(i);
        }
    }
    const SliceResult result = sliced(mesh, at_explicit(part));
    REQUIRE(result.layers.size() == places.size());
    for (std::size_t l = 0; l < places.size(); ++l) {
        const Layer& in_whole = whole.layers[places[l]];
        REQUIRE(result.layers[l].plane == in_whole.plane);
        REQUIRE(result.layers[l].segments == in_whole.segments);
        REQUIRE(outlines(result, result.layers[l]) == outlines(whole, in_whole));
    }
}

bool is_whole(const std::string& mesh_name) {
    return mesh_name != "torn ball";
}

/// The parents of contours that cross depend on where these start, and so on the position of the mesh.
bool crosses(const std::string& mesh_name) {
    return mesh_name == "crossing balls";
}

/// Where solids share an edge, flipping joins the space around them instead.
bool touches(const std::string& mesh_name) {
    return mesh_name == "boxes that share an edge";
}

}  // namespace

TEST_CASE("moving, mirroring and turning the mesh does the same to its contours", "[engine][invariants]") {
    struct Case {
        const char* name;
        shapes::Soup (*mesh)(const shapes::Soup&);
        Point (*point)(Point);
        bool mirrors = false;
        std::int32_t up = 0;  ///< grid units
    };
    constexpr auto moved = [](const shapes::Soup& mesh) {
        return shapes::moved(mesh, {64 + 2 * unit_mm, -32, 16 * layer_mm});
    };
    const Case cases[] = {
        {"moved along the grid", moved,
         [](Point p) {
             return Point{p.x + (64 << 20) + 2, p.y - (32 << 20)};
         },
         false, 16 << 18},
        {"mirrored in x", [](const shapes::Soup& mesh) { return shapes::flipped(turned(mesh, -1, 0, 0, 1)); },
         [](Point p) {
             return Point{-p.x, p.y};
         },
         true},
        {"mirrored in y", [](const shapes::Soup& mesh) { return shapes::flipped(turned(mesh, 1, 0, 0, -1)); },
         [](Point p) {
             return Point{p.x, -p.y};
         },
         true},
        {"a quarter turn", [](const shapes::Soup& mesh) { return turned(mesh, 0, -1, 1, 0); },
         [](Point p) {
             return Point{-p.y, p.x};
         }},
        {"half a turn", [](const shapes::Soup& mesh) { return turned(mesh, -1, 0, 0, -1); },
         [](Point p) {
             return Point{-p.x, -p.y};
         }}};
    for (const auto& [name, mesh] : meshes()) {
        const SliceResult here = sliced(mesh, uniform(layer_mm, unit_mm));
        for (const Case& one : cases) {
            INFO(name << ", " << one.name);
            const SliceResult there = sliced(one.mesh(mesh), uniform(layer_mm, unit_mm));
            check_carried_over(here, there, {one.point, one.mirrors, one.up != 0 || !crosses(name)});
            for (std::size_t l = 0; l < here.layers.size(); ++l) {
                REQUIRE(there.layers[l].plane.z() - here.layers[l].plane.z() == one.up);
            }
        }
    }
}

TEST_CASE("flipping facets reverses orientations and changes nothing else", "[engine][invariants]") {
    // Orientations times `over`, with the sizes of their contours.
    const auto orientations = [](const SliceResult& result, const Layer& layer, int over) {
        std::vector<std::tuple<int, std::uint32_t, std::uint32_t, double>> all;
        for (const Contour& c : result.contours_of(layer)) {
            all.emplace_back(over * c.orientation, c.segments, c.point_count, std::abs(c.twice_area.to_double()));
        }
        std::sort(all.begin(), all.end());
        return all;
    };
    for (const auto& [name, mesh] : meshes()) {
        if (touches(name)) {
            continue;
        }
        INFO(name);
        const SliceResult here = sliced(mesh, uniform(layer_mm, unit_mm));
        const SliceResult there = sliced(shapes::flipped(mesh), uniform(layer_mm, unit_mm));
        REQUIRE(here.layers.size() == there.layers.size());
        for (std::size_t l = 0; l < here.layers.size(); ++l) {
            REQUIRE(orientations(here, here.layers[l], -1) == orientations(there, there.layers[l], 1));
        }
    }
}

TEST_CASE("a part of a list of planes gives the same layers as the whole list", "[engine][invariants]") {
    for (const auto& [name, mesh] : meshes()) {
        INFO(name);
        const std::vector<double> heights = vertex_heights(mesh, unit_mm);
        const SliceResult whole = sliced(mesh, at_explicit(heights));
        const std::size_t half = heights.size() / 2;
        check_part(mesh, heights, whole, [half](std::size_t i) { return i < half; });
        check_part(mesh, heights, whole, [half](std::size_t i) { return i >= half; });
        check_part(mesh, heights, whole, [](std::size_t i) { return i % 7 == 3; });
    }
}

TEST_CASE("planes at the height of every vertex lose no triangle", "[engine][invariants]") {
    for (const auto& [name, mesh] : meshes()) {
        for (const lamella::PlaneSide side : {lamella::PlaneSide::below, lamella::PlaneSide::above}) {
            SliceOptions options = at_explicit(vertex_heights(mesh, unit_mm));
            options.plan.side = side;
            const SliceResult result = sliced(mesh, options);
            INFO(name << ", above " << (side == lamella::PlaneSide::above));
            CHECK(lost_at_vertex_heights(result, mesh).empty());
            CHECK((result.summary.open_contours == 0) == is_whole(name));
            CHECK(hash_result(sliced(shapes::shuffled(mesh, 1), options)) == hash_result(result));
        }
    }
}

TEST_CASE("the ridge of a steep roof is a flat contour without parent", "[engine][invariants]") {
    // The roof is 2 mm wide at the eaves and 64 mm high, so one unit below the ridge its width rounds to zero. It stands
    // in a courtyard.
    const shapes::Xyz eaves[] = {{0, -1, 0}, {8, -1, 0}, {8, 1, 0}, {0, 1, 0}};
    const shapes::Xyz ridge[] = {{2, 0, 64}, {6, 0, 64}};
    using shapes::quad;
    const shapes::Soup roof =
        shapes::joined({quad(eaves[3], eaves[2], eaves[1], eaves[0]), quad(eaves[0], eaves[1], ridge[1], ridge[0]),
                        quad(eaves[2], eaves[3], ridge[0], ridge[1]), shapes::triangle(eaves[1], eaves[2], ridge[1]),
                        shapes::triangle(eaves[3], eaves[0], ridge[0])});
    const shapes::Soup yard = shapes::joined(
        {shapes::box({-20, -20, -10}, {20, 20, 80}), shapes::flipped(shapes::box({-10, -10, -5}, {10, 10, 75}))});
    const SliceResult result = sliced(shapes::joined({yard, roof}), at_heights({64}));
    REQUIRE(result.contours.size() == 3);
    CHECK(contours_at(result, 0)[2].substr(0, 12) == "flat 0 x6 in");
    CHECK(result.contours[2].parent == -1);
    CHECK(lost_at_vertex_heights(result, shapes::joined({yard, roof})).empty());
}
