// Where contour edges come from, compared with each triangle cut by itself: as the mesh gives them, and as the edges of
// regions and parts.
#include <compare>

#include "engine/slicing.hpp"
#include "golden/inputs.hpp"
#include "oracle/oracle.hpp"

using namespace lamella;

namespace {

/// The piece that a plane cuts of a triangle, as its facet runs.
struct Cut {
    Point from;
    Point to;
    PointOrigin origin;
    friend auto operator<=>(const Cut&, const Cut&) = default;
};
using Cuts = std::vector<Cut>;

/// None if the cut has no length.
std::optional<Cut> cut_of(const oracle::Triangle& t, PointOrigin origin, std::int32_t z) {
    const std::vector<Segment> segments = oracle::segments_at(std::span(&t, 1), z);
    if (segments.empty() || segments[0].from == segments[0].to) {
        return {};
    }
    for (std::uint8_t e = 0; e < 3; ++e) {
        const std::int32_t from = t[e].z;
        const std::int32_t to = t[(e + 1U) % 3].z;
        if (from > z && to < z) {
            origin.edge = e;  // the facet's segment starts where the facet runs down
        } else if (from < z && to > z) {
            origin.end_edge = e;
        }
    }
    return Cut{segments[0].from, segments[0].to, origin};
}

/// The triangles of a mesh on the grid of a result.
class Triangles {
public:
    Triangles(const shapes::Soup& soup, const SliceResult& result, std::uint16_t part = 0) : part_(part) {
        std::map<oracle::Triangle, std::uint32_t> smallest;
        for (std::uint32_t t = 0; t < soup.size() / 9; ++t) {
            const auto own = oracle::quantise(std::span(soup).subspan(9 * t, 9), result.info.grid_mm);
            oracle::Triangle turned = triangles_.emplace_back(own.empty() ? oracle::Triangle{} : own[0]);
            std::rotate(turned.begin(), std::min_element(turned.begin(), turned.end()), turned.end());
            stands_for_.push_back(smallest.emplace(turned, t).first->second);
        }
    }

    /// The cuts of all triangles whose cut has a length. Of triangles with the same corners the smallest stands for all.
    void add_cuts(PlaneHeight plane, Cuts& cuts) const {
        for (const std::uint32_t t : stands_for_) {
            if (const std::optional<Cut> cut = cut_of(triangles_[t], {t, part_}, plane.z())) {
                cuts.push_back(*cut);
            }
        }
    }

    /// The contour edges of a layer that come from a triangle of this part and have a length, as the facets run.
    void add_edges(const LayerView& layer, Cuts& edges) const {
        for (const Contour& contour : layer.contours) {
            const std::span<const Point> points = layer.points_of(contour);
            const bool open = contour.role == Role::open;
            for (std::size_t i = 0; i < points.size() - (open ? 1 : 0) && contour.part == part_; ++i) {
                const Point next = points[i + 1 < points.size() ? i + 1 : 0];
                const PointOrigin& origin = layer.origins_of(contour)[i];
                if (origin.triangle != no_triangle && points[i] != next) {
                    edges.push_back(runs_down(origin)
                                        ? Cut{points[i], next, origin}
                                        : Cut{next, points[i], {origin.triangle, part_, origin.end_edge, origin.edge}});
                }
            }
        }
    }

private:
    bool runs_down(const PointOrigin& origin) const {
        const oracle::Triangle& t = triangles_[origin.triangle];
        return t[(origin.edge + 1U) % 3].z < t[origin.edge].z;
    }

    std::vector<oracle::Triangle> triangles_;  // equal corners: degenerate
    std::vector<std::uint32_t> stands_for_;    // of each: the smallest with the same corners
    std::uint16_t part_;
};
using Meshes = std::vector<shapes::Soup>;

std::vector<Triangles> triangles_of(const Meshes& meshes, const SliceResult& result) {
    std::vector<Triangles> all;
    for (const shapes::Soup& mesh : meshes) {
        all.emplace_back(mesh, result, static_cast<std::uint16_t>(all.size()));
    }
    return all;
}

/// Every triangle that a plane cuts is named by its contour edge, and by no other.
void check_contours(const Meshes& parts, const SliceResult& result) {
    const std::vector<Triangles> all = triangles_of(parts, result);
    for (const LayerView layer : result) {
        Cuts cuts;
        Cuts edges;
        for (const Triangles& triangles : all) {
            triangles.add_cuts(layer.plane, cuts);
            triangles.add_edges(layer, edges);
        }
        std::sort(cuts.begin(), cuts.end());
        std::sort(edges.begin(), edges.end());
        INFO("plane " << layer.plane.z());
        REQUIRE(edges == cuts);
    }
}

/// By looking at all cuts: of those that the edge lies on, the one of the smallest part and triangle.
std::optional<PointOrigin> origin_along(const Cuts& cuts, Point from, Point to) {
    std::optional<PointOrigin> smallest;
    for (const auto& [begin, end, own] : cuts) {
        if (rings::lies_on(begin, end, from) && rings::lies_on(begin, end, to) &&
            (!smallest || std::pair(own.part, own.triangle) < std::pair(smallest->part, smallest->triangle))) {
            smallest = own;
            smallest->edge = from == begin ? own.edge : from == end ? own.end_edge : no_edge;
            smallest->end_edge = to == end ? own.end_edge : to == begin ? own.edge : no_edge;
        }
    }
    return smallest;
}

/// Requires that each edge of the region has the origin that looking at all cuts finds, which is there.
void check_region(const Meshes& parts, const SliceResult& result) {
    const std::vector<Triangles> all = triangles_of(parts, result);
    for (const LayerView layer : result) {
        Cuts cuts;
        for (const Triangles& triangles : all) {
            triangles.add_cuts(layer.plane, cuts);
        }
        for (const Contour& contour : layer.contours) {
            const auto points = layer.points_of(contour);
            for (std::size_t i = 0; i < points.size(); ++i) {
                const auto along = origin_along(cuts, points[i], points[i + 1 < points.size() ? i + 1 : 0]);
                INFO("plane " << layer.plane.z() << ", edge from " << points[i].x << ", " << points[i].y);
                REQUIRE(along.has_value());
                REQUIRE(layer.origins_of(contour)[i] == *along);
            }
        }
    }
}

SliceOptions with_origins(SliceOptions options, FillRule rule = FillRule::contours) {
    options.region.fill_rule = rule;
    options.origins = true;
    return options;
}

/// Requires a valid result whose origins suit the mesh and that is otherwise the same as without origins.
SliceResult traced(const Source& source, SliceOptions options, const Tuning& tuning = {}) {
    SliceResult result = sliced(source, with_origins(options, options.region.fill_rule), {}, tuning);
    REQUIRE(result.origins.size() == result.points.size());
    require_ok(audits::structure_of(result, source));
    options.origins = false;
    const SliceResult without = sliced(source, options, {}, tuning);
    REQUIRE(without.origins.empty());
    REQUIRE(without.hash() == result.hash());
    return result;
}
SliceResult traced(const shapes::Soup& soup, const SliceOptions& options, const Tuning& tuning = {}) {
    return traced(view_of(soup), options, tuning);
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

/// Boxes with corners on whole mm, so that their sides cross and coincide exactly.
shapes::Soup random_boxes(unsigned seed, int count) {
    std::mt19937 random(seed);
    const auto draw = [&](unsigned below) { return static_cast<double>(random() % below); };
    shapes::Soup boxes;
    for (int i = 0; i < count; ++i) {
        const double x = draw(6);
        const double y = draw(6);
        shapes::append(boxes, shapes::box({x, y, 0}, {x + 1 + draw(4), y + 1 + draw(4), 4}));
    }
    return boxes;
}

std::size_t without_triangle(const SliceResult& result) {
    return static_cast<std::size_t>(std::count(result.origins.begin(), result.origins.end(), PointOrigin()));
}

TEST_CASE("each contour edge names the triangle that it cuts, and the edges at its ends, in any order of triangles",
          "[engine][origins]") {
    for (const auto& [mesh_name, mesh] : difficult_meshes()) {
        for (const auto& [plan_name, options] : shape_cases::plans(mesh)) {
            INFO(mesh_name << ", " << plan_name);
            check_contours({mesh}, traced(mesh, options));
        }
        INFO(mesh_name << ", shuffled, in one band");
        const shapes::Soup shuffled = shapes::shuffled(mesh, 4);
        check_contours({shuffled}, traced(shuffled, uniform(0.125), {.band_planes = 1000}));
    }
}

TEST_CASE("contour edges of random triangles name them, joined gaps no triangle", "[engine][origins][repair][random]") {
    const auto seed = GENERATE(range(1U, 1 + rounds(149)));
    for (const ContourForm form : {ContourForm::swept, ContourForm::assembled}) {
        for (const std::uint64_t range : {2U, 3U, 8U}) {
            SliceOptions options = through_quarters(range);
            const shapes::Soup soup = shapes::random_soup(seed, 30, range);
            const shapes::Soup solids = shapes::random_tetrahedra(seed, 6, range);
            INFO("seed " << seed << ", range " << range << ", assembled " << (form == ContourForm::assembled));
            check_contours({soup}, traced(soup, options, {.form = form}));
            check_contours({solids}, traced(solids, options, {.form = form}));
            options.stitch_mm = 0.75;
            const SliceResult stitched = traced(soup, options, {.form = form});
            check_contours({soup}, stitched);
            const auto gaps = std::count_if(stitched.stitches.begin(), stitched.stitches.end(),
                                            [](const Stitch& gap) { return gap.from != gap.to; });
            CHECK(without_triangle(stitched) == static_cast<std::size_t>(gaps));
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
    const shapes::Soup open = shapes::without(shapes::box({0, 0, 0}, {4, 4, 4}), 4, 2);  // no front
    const SliceResult result = traced(open, at_heights({2}));
    REQUIRE(result.contours[0].role == Role::open);
    const PointOrigin& last = result.origins[result.origins.size() - 2];
    CHECK(result.origins[result.origins.size() - 1] == PointOrigin{last.triangle, 0, last.end_edge, no_edge});
}

TEST_CASE("an audit of the structure finds origins that do not suit the result or the mesh", "[engine][origins]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const MeshView mesh = view_of(box);
    SliceResult result = traced(box, at_heights({2, 3}));
    REQUIRE(result.origins[0] == PointOrigin{5, 0, 2, 0});
    const auto complaint = [&](const PointOrigin& origin, const Source& source) {
        const PointOrigin right = std::exchange(result.origins[0], origin);
        const Status status = audits::structure_of(result, source);
        result.origins[0] = right;
        return status ? std::string() : status.error().message;
    };
    constexpr auto none = no_triangle;
    const std::pair<PointOrigin, const char*> damages[] = {
        // Seen without the mesh.
        {{none, 0, 2, 0}, "an origin without a triangle, yet with an edge or a part"},
        {{5, 0, 4, 0}, "the origin names an edge that no triangle has"},
        {{5, 0, 2, 2}, "the contour edge begins and ends on the same edge of its triangle"},
        {{12, 0, 2, 0}, "the origin's triangle is not in the mesh"},
        {{5, 1, 2, 0}, "the origin's part is not the contour's"},
        // Seen by the mesh.
        {{}, "no origin, though nothing was made, joined or simplified here"},
        {{0, 0, 2, 0}, "the plane does not cut the origin's triangle"},
        {{9, 0, 2, 0}, "the point does not lie on the edge that its origin names"},
        {{5, 0, 1, 0}, "the point does not lie on the edge that its origin names"},
        {{5, 0, 2, 1}, "the contour edge does not end on the edge that its origin names"},
        {{9, 0, no_edge, no_edge}, "the contour edge does not lie in the origin's triangle"}};
    for (const auto& [origin, message] : damages) {
        CHECK_THAT(complaint(origin, mesh), Catch::EndsWith("contour 0, point 0: " + std::string(message)));
    }
    CHECK(complaint({5, 0, 2, 0}, mesh).empty());
    CHECK(complaint({5, 0, 2, 0}, view_of(shapes::joined({box, box}))) == "the result is not of this mesh");
    CHECK(complaint({5, 0, 2, 0}, std::vector<Part>(2, {.mesh = mesh})) == "the result is not of so many parts");
    // A mesh of which one facet looks the other way.
    shapes::Soup back = box;
    const shapes::Soup flipped = shapes::flipped(box);
    std::copy_n(flipped.begin() + 9 * 5, 9, back.begin() + 9 * 5);
    result.origins[8] = {5, 0, 0, 2};
    CHECK_THAT(complaint({5, 0, 0, 2}, view_of(back)), Catch::EndsWith("the contour edge runs against its facet"));
    result.origins.set_size(15);
    CHECK(audits::structure_of(result).error().message == "there are not as many origins as points");
}

TEST_CASE("edges of a region keep the triangles along which they run, bent ones too", "[engine][origins][regions]") {
    const auto seed = GENERATE(range(1U, 1 + rounds(199)));
    for (const FillRule rule : {FillRule::non_zero, FillRule::even_odd, FillRule::positive}) {
        const shapes::Soup boxes = random_boxes(seed, 5);
        check_region({boxes}, traced(boxes, with_origins(at_heights({1, 2, 3}), rule)));
        const shapes::Soup tangle = shapes::random_tetrahedra(seed, 6, 9);
        const SliceOptions options = with_origins(at_heights({1.25, 4.5}, 1.0 / 64), rule);
        CHECK((seed > 60 || without_triangle(traced(tangle, options)) == 0));
    }
}

TEST_CASE("what offset and closing move comes from no triangle, what they leave keeps its origin",
          "[engine][origins][regions]") {
    const shapes::Soup boxes = shapes::joined(
        {shapes::box({0, 0, 0}, {4, 4, 4}), shapes::box({4.5, 0, 0}, {8, 4, 4}), shapes::box({20, 0, 0}, {24, 4, 4})});
    const SliceOptions plain = with_origins(at_heights({2}, 1.0 / 1024), FillRule::non_zero);
    SliceOptions options = plain;
    options.region.offset_mm = 0.25;
    const SliceResult grown = traced(boxes, options);
    CHECK(without_triangle(grown) == grown.points.size());
    options = plain;
    options.region.closing_mm = 0.5;
    const SliceResult closed = traced(boxes, options);
    REQUIRE(closed.contours.size() == 2);
    CHECK(without_triangle(closed) == closed.contours[0].point_count);
    for (const PointOrigin& origin : closed.origins_of(closed.contours[1])) {
        CHECK(origin.triangle >= 24);
    }
    // A notch, whose short floor closing folds into the corner of its walls. Each side has a point in its middle: the
    // floor's three points become one, and the two edges beside it longer.
    const shapes::Soup block =
        shapes::walls({{0, 0}, {20, 0}, {20, 10}, {12, 10}, {10.0625, 8}, {9.9375, 8}, {8, 10}, {0, 10}});
    options.region.closing_mm = 0.2;
    const SliceResult before = traced(block, plain);
    const SliceResult folded = traced(block, options);
    REQUIRE(folded.points.size() == before.points.size() - 2);
    CHECK(without_triangle(before) == 0);
    CHECK(without_triangle(folded) == 2);
}

TEST_CASE("an edge of several without the points between comes from the first of them", "[engine][origins][regions]") {
    SliceOptions options = with_origins(at_heights({2}), FillRule::non_zero);
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    for (const shapes::Soup& mesh : {box, shapes::flipped(box)}) {
        options.region.drop_collinear = false;
        const SliceResult whole = traced(mesh, options);
        options.region.drop_collinear = true;
        const SliceResult dropped = traced(mesh, options);
        REQUIRE(whole.points.size() == 8);
        REQUIRE(dropped.points.size() == 4);
        for (std::size_t i = 0; i < 4; ++i) {
            REQUIRE(dropped.points[i] == whole.points[2 * i]);
            PointOrigin expected = whole.origins[2 * i];
            expected.end_edge = no_edge;
            CHECK(dropped.origins[i] == expected);
        }
    }
}

TEST_CASE("origins name the part where there are several, up to 65535", "[engine][origins][parts]") {
    const Meshes meshes = {random_boxes(1, 3), random_boxes(2, 3)};
    const std::vector<Part> parts = {{.mesh = view_of(meshes[0])}, {.mesh = view_of(meshes[1])}};
    SliceOptions options = with_origins(at_heights({1, 3}), FillRule::non_zero);
    options.unite_parts = true;
    const SliceResult united = traced(parts, options);
    CHECK(std::any_of(united.contours.begin(), united.contours.end(),
                      [](const Contour& contour) { return contour.part == several_parts; }));
    check_region(meshes, united);
    const shapes::Soup one = shapes::triangle({0, 0, 0}, {4, 0, 4}, {0, 4, 4});
    const Error error = failure_of(std::vector<Part>(65536, Part{.mesh = view_of(one)}), with_origins(at_heights({2})));
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK(error.message == "origins name one of at most 65535 parts, not of 65536");
}

}  // namespace
