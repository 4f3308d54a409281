#include <cmath>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "engine/slicing.hpp"
#include "lamella/io/report.hpp"
#include "write/samples.hpp"

using namespace lamella;
using Catch::Contains;
using nlohmann::json;

namespace {

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

}  // namespace

TEST_CASE("report: counts, grid, box and volume", "[write]") {
    const json report = report_of(write_test::square_with_hole());
    require_members(report, json::parse(R"({"planes": 3, "segments": 10, "contours": 3, "holes": 1, "open_contours": 1,
        "flat_contours": 0, "overruled_contours": 0, "grid_mm": 0.5, "frame": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]})"));
    CHECK(report.at("box_mm").at("max") == json({10, 10, 10}));
    CHECK(report.at("solid_volume_mm3").is_null());  // of the open layer no area is known
    CHECK(report.at("open").at("height_share") == 0.5);
    CHECK(report.at("open").at("closed_by_mm").get<double>() == Approx(std::sqrt(20)));
}

TEST_CASE("report: what the program adds stands where it asked for it", "[write]") {
    SliceResult result = write_test::square_with_hole();
    result.info.triangles = 38142;
    result.info.degenerate = 2;
    result.info.threads = 8;
    result.info.bands = 5;
    result.info.ms = {.bucket = 1, .sweep = 2, .contours = 3, .nesting = 4, .fill = 6};
    const std::vector<std::string> warnings = {"one", "two"};
    const std::vector<ReportMember> members = {{ReportPlace::at_end, "warnings", std::span<const std::string>(warnings)},
                                               {ReportPlace::after_mesh, "output", nullptr},
                                               {ReportPlace::in_times, "read", 5.0},
                                               {ReportPlace::in_times, "total", 28.0},
                                               {ReportPlace::after_times, "peak_rss_bytes", std::uint64_t{1} << 30}};
    json report = report_of(result, {.mesh_name = "liver.stl", .members = members});
    CHECK(report.at("ms").at("report") > 0);
    report.at("ms").erase("report");
    require_members(report, json::parse(R"({
        "ms": {"bucket": 1, "sweep": 2, "contours": 3, "nesting": 4, "fill": 6, "read": 5, "total": 28},
        "triangles": 38142, "degenerate": 2, "threads": 8, "bands": 5, "peak_rss_bytes": 1073741824, "mesh": "liver.stl",
        "output": null, "warnings": ["one", "two"]})"));
}

TEST_CASE("report: of a mesh that could not be used it holds the name and what the program adds", "[write]") {
    const ReportMember error{.key = "error", .value = std::string_view("a.stl: is empty")};
    const std::string text = value_of(make_mesh_json({.mesh_name = "a.stl", .members = {&error, 1}}));
    CHECK(json::parse(text) == json({{"mesh", "a.stl"}, {"error", "a.stl: is empty"}}));
}

TEST_CASE("report: the hash is the result's, in sixteen digits", "[write]") {
    const SliceResult result = write_test::square_with_hole();
    const auto digits = report_of(result).at("output_hash").get<std::string>();
    CHECK(digits.size() == 16);
    CHECK(std::stoull(digits, nullptr, 16) == result.hash());
}

TEST_CASE("report: every kind of plan says what it was", "[write]") {
    SliceResult result = write_test::square_with_hole();
    SECTION("uniform") {
        result.info.options.layer_height_mm = 0.032;
        result.info.options.planes = {.first_height_mm = 0.008, .datum = Datum::zero};
        const json plan = report_of(result).at("plan");
        require_members(plan, json::parse(R"({"kind": "uniform", "layer_height_mm": 0.032, "first_height_mm": 0.008,
            "datum": "zero", "side": "below"})"));
        CHECK_THAT(plan.at("rule").get<std::string>(), Contains("one grid unit down"));
    }
    SECTION("uniform, first plane in the middle") {
        CHECK(report_of(result).at("plan").at("first_height_mm") == nullptr);
        CHECK(report_of(result).at("plan").at("datum") == "mesh-min");
    }
    SECTION("explicit") {
        result.info.options.heights_mm = std::vector<double>{1, 2, 5};
        result.info.options.planes.side = PlaneSide::above;
        require_members(report_of(result).at("plan"), {{"kind", "explicit"}, {"heights", 3}, {"side", "above"}});
    }
}

TEST_CASE("report: every layer with open polylines is listed, with the first ten gaps of each", "[write]") {
    using write_test::Ring;
    std::vector<Ring> many;
    for (std::int32_t i = 0; i < 13; ++i) {
        many.push_back({Role::open, {{0, 10 * i}, {4, 10 * i + 1}, {6, 10 * i + 8}}});
    }
    const std::vector<Ring> square{{Role::outer, {{0, 0}, {10, 0}, {10, 10}, {0, 10}}}};
    std::vector<Ring> one = square;
    one.push_back({Role::open, {{20, 0}, {20, 3}}});
    std::vector<std::vector<Ring>> layers{many, square, {}, one};
    layers.insert(layers.end(), 150, {{Role::open, {{0, 0}, {2, 0}}}});
    const json open = report_of(write_test::result_of(layers, 0.5)).at("open_layers");

    REQUIRE(open.size() == 2 + 150);
    require_members(open[0], {{"layer", 0}, {"count", 13}, {"not_listed", 3}});
    REQUIRE(open[0].at("first").size() == 10);
    CHECK(open[0].at("first")[9] == json({{"from_mm", {3, 49}}, {"to_mm", {0, 45}}, {"gap_mm", 5}}));
    CHECK(open[1] == json::parse(R"({"layer": 3, "plane_mm": 1.75, "cut_mm": 3.5, "count": 1, "not_listed": 0,
        "first": [{"from_mm": [10, 1.5], "to_mm": [10, 0], "gap_mm": 1.5}]})"));
    CHECK(open.back().at("layer") == 153);
    CHECK(report_of(write_test::result_of({square}, 0.5)).at("open_layers").empty());
}

TEST_CASE("report: every closed gap is listed, however many", "[write]") {
    SliceResult result = write_test::square_with_hole();
    CHECK(report_of(result).at("gaps").at("closings").empty());
    result.info.options.stitch_mm = 7;
    result.stitches.resize_discarding(500);
    for (std::int32_t i = 0; i < 500; ++i) {
        result.stitches[static_cast<std::size_t>(i)] = {static_cast<std::uint64_t>(i / 250), {i, 0}, {i, i == 123 ? 12 : 1}};
    }
    const json gaps = report_of(result).at("gaps");
    require_members(
        gaps, {{"reach_mm", 7}, {"direction", "oriented"}, {"closed", 500}, {"longest_mm", 6}, {"total_mm", 499 * 0.5 + 6}});
    REQUIRE(gaps.at("closings").size() == 500);
    CHECK(gaps.at("closings")[123] == json::parse(R"({"layer": 0, "plane_mm": 0.25, "cut_mm": 0.5, "from_mm": [61.5, 0],
        "to_mm": [61.5, 6], "length_mm": 6})"));
    CHECK(gaps.at("closings")[499].at("layer") == 1);
}

TEST_CASE("report: a file name that is not UTF-8 or holds quotes still gives JSON", "[write]") {
    const json report = report_of(write_test::square_with_hole(), {.mesh_name = "a\xff\"b\n.stl"});
    CHECK(report.at("mesh") == "a\\xff\"b\n.stl");
}

TEST_CASE("report: rules of regions and parts are there where they were asked for", "[write]") {
    SliceResult result = write_test::square_with_hole();
    CHECK_FALSE(report_of(result).contains("region"));
    CHECK_FALSE(report_of(result).contains("parts"));
    result.info.options.region.flag_closing_mm = 0.5;
    result.info.would_close_contours = 2;
    result.info.part_count = 2;
    const json report = report_of(result);
    CHECK(report.at("region").at("would_close_contours") == 2);
    CHECK(report.at("region").at("fill_from") == json::array());
    CHECK(report.at("parts") == 2);
    CHECK(report.at("part_regions") == "separate");
    result.info.options.unite_parts = true;
    CHECK(report_of(result).at("part_regions") == "united");
}
