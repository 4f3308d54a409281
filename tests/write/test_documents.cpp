// Reports and SVG files of one layer put together by hand, with numbers that the expected texts can be worked out from.
// Those of whole meshes, with all that slices say of themselves: tests/golden. And JSON as text, read back by a library.
#include <cmath>
#include <limits>
#include <numeric>
#include <regex>
#include <sstream>

#include <nlohmann/json.hpp>

#include "engine/slicing.hpp"
#include "io/write/json.hpp"
#include "lamella/io/layer_file.hpp"
#include "lamella/io/report.hpp"
#include "temp_folder.hpp"

using namespace lamella;
using Catch::Contains;
using nlohmann::json;

namespace {

using Line = std::vector<Point>;

/// Closed rings and open polylines on a grid of `grid_mm`, in a layer from 0 to 0.5 mm.
SliceResult layer_of(const std::vector<Line>& closed, const std::vector<Line>& open, double grid_mm) {
    std::vector<Segment> segments;
    std::uint64_t key = 0;
    const auto add = [&](const Line& line, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t next = (i + 1) % line.size();
            segments.push_back({.from_key = {key + i}, .to_key = {key + next}, .from = line[i], .to = line[next]});
        }
        key += line.size();
    };
    for (const Line& line : closed) {
        add(line, line.size());
    }
    for (const Line& line : open) {
        add(line, line.size() - 1);
    }
    SliceResult result = value_of(assemble(segments));
    result.info.grid_mm = grid_mm;
    result.info.box.max_mm = {10, 10, 10};
    result.layers[0].bottom_mm = 0;
    result.layers[0].plane_mm = 0.25;
    result.layers[0].top_mm = 0.5;
    result.layers[0].plane = PlaneHeight(1);
    return result;
}

/// A square with a square hole, 10 and 4 mm wide, and an open polyline, on a grid of 0.5 mm.
SliceResult square_with_hole() {
    return layer_of({{{0, 0}, {20, 0}, {20, 20}, {0, 20}}, {{6, 6}, {6, 14}, {14, 14}, {14, 6}}}, {{{1, -3}, {5, 5}}}, 0.5);
}

/// Members of a report, whatever else it has.
void require_members(const json& report, const json& expected) {
    for (const auto& [key, value] : expected.items()) {
        INFO(key);
        CHECK(report.at(key) == value);
    }
}

json report_of(const SliceResult& result, const ReportParts& parts = {}) {
    const std::string text = value_of(make_report_json(result, parts));
    REQUIRE(text.ends_with("}\n"));
    return json::parse(text);
}

std::string svg_of(const SliceResult& result) {
    const TempFolder folder;
    value_of(write_layers(result, folder / "a.svg"));
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

/// The numbers of the only points="..." of the SVG.
std::vector<double> only_points(const std::string& svg) {
    REQUIRE(count(svg, " points=\"") == 1);
    const std::size_t begin = svg.find(" points=\"") + 9;
    std::string numbers = svg.substr(begin, svg.find('"', begin) - begin);
    std::replace(numbers.begin(), numbers.end(), ',', ' ');
    std::istringstream in(numbers);
    return {std::istream_iterator<double>(in), {}};
}

TEST_CASE("report: counts, open polylines, and what the program adds where it asked for it", "[write]") {
    SliceResult result = square_with_hole();
    result.info.threads = 8;
    result.info.bands = 5;
    result.info.ms = {.bucket = 1, .sweep = 2, .contours = 3, .nesting = 4, .fill = 6};
    result.info.options.heights_mm = std::vector<double>{1, 2, 5};
    result.info.options.planes.side = PlaneSide::above;
    const std::vector<std::string> warnings = {"one", "two"};
    const std::vector<ReportMember> members = {{ReportPlace::at_end, "warnings", std::span<const std::string>(warnings)},
                                               {ReportPlace::after_mesh, "output", nullptr},
                                               {ReportPlace::in_times, "read", 5.0},
                                               {ReportPlace::in_times, "total", 28.0},
                                               {ReportPlace::after_times, "peak_rss_bytes", std::uint64_t{1} << 30}};
    json report = report_of(result, {.mesh_name = "a\xff\"b\n.stl", .members = members});
    CHECK(report.at("ms").at("report") > 0);
    report.at("ms").erase("report");
    require_members(report, json::parse(R"({
        "ms": {"bucket": 1, "sweep": 2, "contours": 3, "nesting": 4, "fill": 6, "read": 5, "total": 28},
        "threads": 8, "bands": 5, "peak_rss_bytes": 1073741824, "output": null, "warnings": ["one", "two"],
        "contours": 3, "holes": 1, "open_contours": 1, "flat_contours": 0, "grid_mm": 0.5})"));
    CHECK(report.at("mesh") == "a\\xff\"b\n.stl");
    require_members(report.at("plan"), {{"kind", "explicit"}, {"heights", 3}, {"side", "above"}});
    CHECK(report.at("solid_volume_mm3").is_null());  // of the open layer no area is known
    CHECK(report.at("open").at("height_share") == 1.0);
    CHECK(report.at("open").at("closed_by_mm").get<double>() == Approx(std::sqrt(20)));
    CHECK(std::stoull(report.at("output_hash").get<std::string>(), nullptr, 16) == result.hash());
    const std::string unusable = value_of(make_mesh_json({.mesh_name = "a.stl", .members = {&members[1], 1}}));
    CHECK(json::parse(unusable) == json({{"mesh", "a.stl"}, {"output", nullptr}}));
}

TEST_CASE("report: the first ten gaps of a layer are listed", "[write]") {
    std::vector<Line> many;
    for (std::int32_t i = 0; i < 13; ++i) {
        many.push_back({{0, 10 * i}, {4, 10 * i + 1}, {6, 10 * i + 8}});
    }
    const json open = report_of(layer_of({}, many, 0.5)).at("open_layers");
    REQUIRE(open.size() == 1);
    require_members(open[0], {{"layer", 0}, {"plane_mm", 0.25}, {"cut_mm", 0.5}, {"count", 13}, {"not_listed", 3}});
    REQUIRE(open[0].at("first").size() == 10);
    CHECK(open[0].at("first")[9] == json({{"from_mm", {3, 49}}, {"to_mm", {0, 45}}, {"gap_mm", 5}}));
}

TEST_CASE("svg: contours, holes, flat contours and open polylines in Slic3r's convention", "[write]") {
    const std::string svg = svg_of(square_with_hole());
    CHECK_THAT(svg, Contains("<g id=\"layer0\" slic3r:z=\"0.25\" lamella:cut-z=\"0.5\" slic3r:layer-height=\"0.5\""));
    CHECK_THAT(svg, Contains("<polygon slic3r:type=\"contour\" points=\"0,0 10,0 10,10 0,10\"/>\n"
                             "<polygon slic3r:type=\"hole\" fill=\"white\" points=\"3,3 3,7 7,7 7,3\"/>"));
    CHECK(std::regex_search(svg,
                            std::regex("<polyline id=\"open2\" slic3r:type=\"open\" fill=\"none\" stroke=\"#[0-9a-f]{6}\" "
                                       "stroke-width=\"[0-9.]+\" points=\"0.5,-1.5 2.5,2.5\"/>")));
    CHECK(count(svg, "<use xlink:href=\"#open2\"/>") == 1);
    CHECK(count(svg, "<g ") == 2);  // the layer and the overlay of open polylines
    CHECK(count(svg, "</g>") == 2);
    CHECK(svg.ends_with("</svg>\n"));
    const std::string flat = svg_of(layer_of({{{0, 0}, {2, 2}}}, {}, 1));
    CHECK_THAT(flat, Contains("<polygon slic3r:type=\"flat\" points=\"0,0 2,2\"/>"));
    CHECK(flat.find("id=\"open\"") == std::string::npos);
    SliceResult nothing;
    nothing.info.grid_mm = 0.5;
    CHECK_THAT(svg_of(nothing), Contains("viewBox=\"-0.01 -0.01 0.02 0.02\""));  // which shows something
}

TEST_CASE("svg: coordinates are within half a unit, or 1e-6 mm, without needless digits", "[write]") {
    const double unit_mm = GENERATE(default_grid_mm, 0.004, 0.0003, 1.0 / 1024, 1.0, 2.0, 1.0 / (1 << 26));
    const Line points{{-grid_limit, grid_limit}, {-1, 1},          {0, -2},        {3, 250},
                      {123456789, -987654321},   {999999, 100000}, {1048576, -10}, {7, -grid_limit}};
    const std::string svg = svg_of(layer_of({}, {points}, unit_mm));
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
    Line points;
    std::vector<double> expected;
    for (std::int32_t i = 0; i < 200'000; ++i) {
        points.push_back({i, -i});
        expected.insert(expected.end(), {double(i), double(-i)});
    }
    CHECK((only_points(svg_of(layer_of({}, {points}, 1))) == expected));
}

TEST_CASE("report and svg: what was done to regions, marks, and parts are there where they were asked for", "[write]") {
    SliceResult result = square_with_hole();
    CHECK_FALSE((report_of(result).contains("region") || report_of(result).contains("parts")));
    CHECK(count(svg_of(result), "class=") + count(svg_of(result), "lamella:part=") == 0);
    result.contours[1].flags |= would_close;
    result.info.options.region = {.fill_rule = FillRule::positive, .closing_mm = 0.25, .flag_closing_mm = 0.5};
    result.info.would_close_contours = 2;
    result.info.part_count = 3;
    result.contours[0].part = 2;
    result.contours[1].part = several_parts;
    const std::string svg = svg_of(result);
    CHECK(count(svg, "class=\"near\"") == 1);
    CHECK(svg.find("slic3r:type=\"hole\"") < svg.find("\" class=\"near\" lamella:part=\"several\"/>\n"));
    CHECK_THAT(svg, Contains("Fill rule positive. Regions closed by 0.25 mm. Contours marked that closing by 0.5 mm would"));
    CHECK(count(svg, " lamella:part=\"2\"/>") == 1);
    CHECK(count(svg, " lamella:part=") == 3);
    for (const bool united : {false, true}) {
        result.info.options.unite_parts = united;
        require_members(report_of(result), {{"parts", 3}, {"part_regions", united ? "united" : "separate"}});
        require_members(report_of(result).at("region"), {{"would_close_contours", 2}, {"fill_from", json::array()}});
    }
}

TEST_CASE("json: all is as the library writes it, what is not finite is null", "[write][json]") {
    std::string ascii(0x80, '\0');
    std::iota(ascii.begin(), ascii.end(), '\0');
    const std::vector<std::string> texts = {ascii,          "\xc3\xa4",        "\xe2\x82\xac", "\xf0\x9f\xa6\xb4",
                                            "\xed\x9f\xbf", "\xf4\x8f\xbf\xbf"};
    constexpr double infinity = std::numeric_limits<double>::infinity();
    JsonText text;
    text.object([&] {
        text.member("a", -3);
        text.object("empty", [] {});
        text.member("none", std::vector<int>{});
        text.list("first", std::vector<int>{1, 2, 3}, 2, [&](int i) { text.object([&] { text.member("i", i); }); });
        text.member("all", std::vector<std::string>{"x", "[", "{"});
        text.member_if(false, "unknown", 5);
        text.member("last", std::array{std::array{1, 2}, std::array{3, 4}});
        text.member("numbers", std::array{0.0, 2.0, -0.1, 1e300, 5e-324, infinity, std::nan("")});
        text.member("most", std::numeric_limits<std::uint64_t>::max());
        text.member("least", std::numeric_limits<std::int64_t>::min());
        text.member("words", std::array{true, false});
        text.member("word", "a\xe2\x82");  // as utf8_text(), of which test_output_file tests more
        text.member("texts", texts);
    });
    auto expected = nlohmann::ordered_json::parse(
        R"({"a": -3, "empty": {}, "none": [], "first": [{"i": 1}, {"i": 2}], "all": ["x", "[", "{"], "unknown": null,
            "last": [[1, 2], [3, 4]], "numbers": [0.0, 2.0, -0.1, 1e300, 5e-324, null, null],
            "most": 18446744073709551615, "least": -9223372036854775808, "words": [true, false], "word": "a\\xe2\\x82"})");
    expected["texts"] = texts;
    CHECK(std::move(text).take() == expected.dump(2) + "\n");
}

TEST_CASE("json: text of any bytes is UTF-8", "[write][json]") {
    for (int first = 0x80; first < 0x100; ++first) {
        for (int second = 1; second < 0x100; ++second) {
            const std::string text = {static_cast<char>(first), static_cast<char>(second), '\x80', '\x80'};
            REQUIRE_NOTHROW(JsonText().value(text));  // the library throws at what is none
        }
    }
}

}  // namespace
