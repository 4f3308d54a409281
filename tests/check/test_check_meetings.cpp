// Faces that cross, overlap or touch.
#include <set>

#include "check/findings.hpp"
#include "mesh/check/meeting.hpp"

namespace lamella::check_test {

using shapes::box;
using shapes::flipped;
using shapes::joined;
using shapes::triangle;

namespace {

Soup tetrahedron(Xyz a, Xyz b, Xyz c, Xyz d) {
    return joined({triangle(a, c, b), triangle(a, b, d), triangle(b, c, d), triangle(c, a, d)});
}

/// Crossings, overlaps and touches.
std::array<std::uint64_t, 3> meetings(const Soup& soup) {
    const MeshCheck check = findings_of(soup);
    return {check.of(Fault::crossing_faces).count, check.of(Fault::overlapping_faces).count,
            check.of(Fault::touching_faces).count};
}

using Three = std::array<std::uint64_t, 3>;

}  // namespace

TEST_CASE("a tetrahedron whose tip pierces a face of another crosses it three times", "[check]") {
    const Soup large = tetrahedron({0, 0, 0}, {30, 0, 0}, {0, 30, 0}, {0, 0, 30});
    const Soup spike = tetrahedron({4, 4, -4}, {6, 4, -4}, {4, 6, -4}, {5, 5, 4});
    const MeshCheck check = findings_of(joined({large, spike}));
    CHECK(counts(check) == Counts{{"crossing_faces", 3}});
    for (const FaultPlace& place : check.of(Fault::crossing_faces).places) {
        REQUIRE(place.point_count == 2);
        CHECK(place.points_mm[0][2] == Approx(0).margin(1e-9));  // the face that is pierced lies in z = 0
        CHECK(place.points_mm[1][2] == Approx(0).margin(1e-9));
        CHECK(place.points_mm[0] < place.points_mm[1]);
        CHECK(place.triangles[0] != place.triangles[1]);
    }
}

TEST_CASE("every pair of faces that meet is found", "[check]") {
    // Small and large triangles, coincidences of every kind.
    const auto seed = static_cast<std::uint64_t>(GENERATE(range(1, 5)));
    const Soup soup = joined({shapes::random_soup(seed, 60, 40), shapes::random_soup(seed + 100, 60, 3),
                              shapes::moved(shapes::random_soup(seed + 200, 100, 6), {15, 15, 15})});
    std::vector<ExactFace> faces;
    std::set<std::set<std::uint32_t>> known;  // faces on the same vertices are tested once
    for (std::size_t at = 0; at < soup.size(); at += 9) {
        std::array<GridVertex, 3> corners;
        std::array<std::uint32_t, 3> ids{};
        for (std::size_t i = 0; i < 3; ++i) {
            const auto grid = [&](std::size_t axis) { return 2 * static_cast<std::int32_t>(soup[at + 3 * i + axis]); };
            corners[i] = {grid(0), grid(1), grid(2)};
            ids[i] = static_cast<std::uint32_t>(corners[i].x + 1000 * (corners[i].y + 1000 * corners[i].z));
        }
        const bool is_new = known.insert({ids.begin(), ids.end()}).second;
        if (const ExactFace face(ids, corners); is_new && face.has_area()) {
            faces.push_back(face);
        }
    }
    Three expected{};
    for (std::size_t i = 0; i < faces.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const Meeting meeting = meet(faces[i], faces[j]);
            expected[0] += meeting == Meeting::cross ? 1 : 0;
            expected[1] += meeting == Meeting::overlap ? 1 : 0;
            expected[2] += meeting == Meeting::touch ? 1 : 0;
        }
    }
    CHECK(expected[0] > 100);
    CHECK(expected[1] > 0);
    CHECK(expected[2] > 10);
    CHECK(meetings(soup) == expected);
}

TEST_CASE("boxes stacked askew overlap where they stand on one another", "[check]") {
    const MeshCheck check = findings_of(joined({box({0, 0, 0}, {2, 2, 2}), box({1, 1, 2}, {3, 3, 4})}));
    CHECK(check.of(Fault::overlapping_faces).count == 2);  // both diagonals lie on x = y
    CHECK(check.of(Fault::crossing_faces).count == 0);
    CHECK(check.of(Fault::touching_faces).count > 0);
    for (const FaultPlace& place : check.of(Fault::overlapping_faces).places) {
        CHECK(place.point_count == 1);
        CHECK(place.points_mm[0][2] == 2);
    }
    CHECK(check.shells.size() == 2);
}

TEST_CASE("closed models give no finding", "[check]") {
    CHECK(findings_of(shapes::octasphere({1, 2, 3}, 30, 5)).clean());
    CHECK(findings_of(shapes::prism(16, 20, 30)).clean());
    CHECK(counts(findings_of(shapes::octasphere({1, 2, 3}, 30, 5))).empty());
}

TEST_CASE("a search of piled up triangles ends at its budget and reports that", "[check]") {
    Soup soup;
    for (int i = 0; i < 6000; ++i) {  // all boxes meet, and no two triangles
        const Soup next = triangle({0, 0, 1.0 * i}, {1, 0, 9000.0 + i}, {0, 1, 9000.0 + i});
        soup.insert(soup.end(), next.begin(), next.end());
    }
    const CheckOptions options{.tolerance_mm = 0};
    const MeshCheck fewer = findings_of(only(soup, 0, 1000), options);
    CHECK(fewer.complete());
    CHECK(make_verdict(fewer).value().find("as far as") == std::string::npos);
    const MeshCheck check = findings_of(soup, options);
    CHECK(check.of(Fault::crossing_faces).at_least);
    CHECK(check.of(Fault::touching_faces).at_least);
    CHECK(check.of(Fault::crossing_faces).count == 0);
    CHECK_FALSE(check.of(Fault::boundary_edge).at_least);
    CHECK_FALSE(check.complete());
    CHECK(make_verdict(check).value() == "not clean: 18000 boundary edges, 6000 boundary loops, as far as was searched");
}

TEST_CASE("a body exported a thousand times meets another as often as if exported once", "[check]") {
    const Soup large = tetrahedron({0, 0, 0}, {30, 0, 0}, {0, 30, 0}, {0, 0, 30});
    const Soup spike = tetrahedron({4, 4, -4}, {6, 4, -4}, {4, 6, -4}, {5, 5, 4});
    Soup soup = spike;
    for (int i = 0; i < 1000; ++i) {
        soup.insert(soup.end(), large.begin(), large.end());
    }
    const MeshCheck check = findings_of(joined({soup, flipped(large)}));
    CHECK(check.complete());
    CHECK(check.of(Fault::crossing_faces).count == 3);
    CHECK(check.of(Fault::duplicate_face).count == 3996);
}

}  // namespace lamella::check_test
