#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <regex>
#include <string>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/io/svg.hpp"
#include "temp_folder.hpp"
#include "write/samples.hpp"

using namespace lamella;
using Catch::Contains;
using write_test::result_of;

namespace {

std::string svg_of(const SliceResult& result) {
    const TempFolder folder;
    require_ok(write_svg(result, folder / "a.svg"));
    REQUIRE(folder.names() == std::vector<std::string>{"a.svg"});
    return bytes_of(folder / "a.svg");
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) {
        ++found;
    }
    return found;
}

/// The numbers of the only points="..." of the text.
std::vector<double> only_points(const std::string& text) {
    REQUIRE(count(text, " points=\"") == 1);
    const std::size_t begin = text.find(" points=\"") + 9;
    std::string numbers = text.substr(begin, text.find('"', begin) - begin);
    std::replace(numbers.begin(), numbers.end(), ',', ' ');
    std::vector<double> values;
    for (const char* at = numbers.c_str(); *at != '\0';) {
        char* end = nullptr;
        values.push_back(std::strtod(at, &end));
        REQUIRE(end != at);
        at = end;
    }
    return values;
}

}  // namespace

TEST_CASE("svg: layers, contours, holes and open polylines in Slic3r's convention", "[write]") {
    const std::string svg = svg_of(write_test::square_with_hole());
    CHECK_THAT(svg, Contains("xmlns:slic3r=\"http://slic3r.org/namespaces/slic3r\""));
    CHECK_THAT(svg, Contains("<g id=\"layer0\" slic3r:z=\"0.25\" lamella:cut-z=\"0.5\" slic3r:layer-height=\"0.5\""));
    CHECK_THAT(svg, Contains("<g id=\"layer1\" slic3r:z=\"0.75\""));
    CHECK_THAT(svg, Contains("<g id=\"layer2\" slic3r:z=\"1.25\""));
    CHECK_THAT(svg, Contains("<polygon slic3r:type=\"contour\" points=\"0,0 10,0 10,10 0,10\"/>\n"
                             "<polygon slic3r:type=\"hole\" fill=\"white\" points=\"3,3 3,7 7,7 7,3\"/>"));
    CHECK(std::regex_search(svg,
                            std::regex("<polyline id=\"open2\" slic3r:type=\"open\" fill=\"none\" stroke=\"#[0-9a-f]{6}\" "
                                       "stroke-width=\"[0-9.]+\" points=\"0.5,-1.5 2.5,2.5\"/>")));
    CHECK(count(svg, "<g ") == 4);  // three layers and the overlay of open polylines
    CHECK(count(svg, "<g ") == count(svg, "</g>"));
    CHECK(count(svg, "<use xlink:href=\"#open2\"/>") == 1);
    CHECK(svg.ends_with("</svg>\n"));
}

TEST_CASE("svg: the picture holds the mesh's box, with y upwards", "[write]") {
    SliceResult result = write_test::square_with_hole();
    result.info.box.min_mm[0] = -30;
    result.info.box.min_mm[1] = 5;
    const std::string svg = svg_of(result);
    // 40 mm by 5 mm and a margin of 2 % of the larger.
    CHECK_THAT(svg, Contains("width=\"41.6mm\" height=\"6.6mm\" viewBox=\"-30.8 -10.8 41.6 6.6\""));
    CHECK(count(svg, "transform=\"scale(1,-1)\"") == 4);
}

TEST_CASE("svg: a result without extent still has a viewBox that shows something", "[write]") {
    const std::string svg = svg_of(result_of({}, 0.5));
    CHECK_THAT(svg, Contains("viewBox=\"-0.01 -0.01 0.02 0.02\""));
    CHECK(svg.ends_with("</svg>\n"));
}

TEST_CASE("svg: flat contours are kept under a type of their own", "[write]") {
    const std::string svg = svg_of(result_of({{{Role::flat, {{0, 0}, {2, 2}}}}}, 1));
    CHECK_THAT(svg, Contains("<polygon slic3r:type=\"flat\" points=\"0,0 2,2\"/>"));
    CHECK(svg.find("id=\"open\"") == std::string::npos);
}

TEST_CASE("svg: grid, rounding rule, datum and frame are stated", "[write]") {
    SliceResult result = write_test::square_with_hole();
    SliceOptions& options = result.info.options;
    options.layer_height_mm = 0.5;
    options.planes = {.first_height_mm = 0.25, .datum = Datum::zero, .side = PlaneSide::above};
    options.frame.transform.m = {0, 1, 0, 2.5, -1, 0, 0, 0, 0, 0, 1, -7};
    const std::string svg = svg_of(result);
    const std::string desc = svg.substr(svg.find("<desc>"), svg.find("</desc>") - svg.find("<desc>"));
    CHECK_THAT(desc, Contains("Grid unit 0.5 mm"));
    CHECK_THAT(desc, Contains("datum zero"));
    CHECK_THAT(desc, Contains("first plane at 0.25 mm above the datum"));
    CHECK_THAT(desc, Contains("then one grid unit up (side above)"));
    CHECK_THAT(desc, Contains(": 0 1 0 2.5 -1 0 0 0 0 0 1 -7."));
}

TEST_CASE("svg: coordinates are within half a unit, or 1e-6 mm, without needless digits", "[write]") {
    const double unit_mm = GENERATE(default_grid_mm, 0.004, 0.0003, 1.0 / 1024, 1.0, 2.0, 1.0 / (1 << 26));
    const std::vector<Point> points{{-grid_limit, grid_limit}, {-1, 1},          {0, -2},        {3, 250},
                                    {123456789, -987654321},   {999999, 100000}, {1048576, -10}, {7, -grid_limit}};
    const std::string svg = svg_of(result_of({{{Role::outer, points}}}, unit_mm));
    const std::vector<double> values = only_points(svg);
    REQUIRE(values.size() == 2 * points.size());
    const double tolerance_mm = std::max(unit_mm / 2, 1e-6);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(unit_mm, i);
        CHECK(std::abs(values[2 * i] - points[i].x * unit_mm) <= tolerance_mm);
        CHECK(std::abs(values[2 * i + 1] - points[i].y * unit_mm) <= tolerance_mm);
    }
    CHECK_FALSE(std::regex_search(svg.substr(svg.find(" points=")), std::regex("\\.[0-9]*0[, \"]|-0[, \"]")));
}

TEST_CASE("svg: more points than fit the buffer arrive in order", "[write]") {
    std::vector<Point> points;
    for (std::int32_t i = 0; i < 200'000; ++i) {
        points.push_back({i, -i});
    }
    std::vector<double> expected;
    for (const Point& point : points) {
        expected.insert(expected.end(), {double(point.x), double(point.y)});
    }
    CHECK((only_points(svg_of(result_of({{{Role::outer, points}}}, 1))) == expected));
}

TEST_CASE("svg: a stop request leaves nothing", "[write]") {
    const TempFolder folder;
    auto stop = []() noexcept { return true; };
    CHECK(code_of(write_svg(write_test::square_with_hole(), folder / "a.svg", {}, {.stop = stop})) == ErrorCode::cancelled);
    CHECK(folder.names().empty());
}

TEST_CASE("svg: near contours are marked, and with several parts each contour names its part", "[write]") {
    SliceResult result = write_test::square_with_hole();
    CHECK(count(svg_of(result), "class=") == 0);
    CHECK(count(svg_of(result), "lamella:part=") == 0);
    result.contours[1].flags |= would_close;
    const std::string marked = svg_of(result);
    CHECK(count(marked, "class=\"near\"") == 1);
    CHECK(marked.find("slic3r:type=\"hole\"") < marked.find("\" class=\"near\"/>\n"));
    result.info.part_count = 3;
    result.contours[0].part = 2;
    result.contours[1].part = several_parts;
    const std::string named = svg_of(result);
    CHECK(count(named, " lamella:part=\"2\"/>") == 1);
    CHECK(count(named, " class=\"near\" lamella:part=\"several\"/>") == 1);
    CHECK(count(named, " lamella:part=") == 3);
}

TEST_CASE("svg: says what was done to regions", "[write]") {
    SliceResult result = write_test::square_with_hole();
    result.info.options.region = {
        .fill_rule = FillRule::positive, .closing_mm = 0.25, .offset_mm = 2, .flag_closing_mm = 0.5};
    CHECK_THAT(svg_of(result),
               Contains("Fill rule positive. Regions closed by 0.25 mm. Regions grown by 2 mm, miter limit 3. Contours "
                        "marked that closing by 0.5 mm would change."));
}
