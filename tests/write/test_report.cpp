#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "lamella/write.hpp"
#include "write/samples.hpp"

using namespace lamella;
using nlohmann::json;

namespace {

json report_of(const SliceResult& result, const ReportContext& context = {}) {
    const Result<std::string> text = report_json(result, context);
    REQUIRE(text.ok());
    REQUIRE(text.value().ends_with("}\n"));
    return json::parse(text.value());
}

}  // namespace

TEST_CASE("report: counts, grid, box and volume", "[write]") {
    const json report = report_of(write_test::square_with_hole());
    CHECK(report.at("planes") == 3);
    CHECK(report.at("segments") == 10);
    CHECK(report.at("contours") == 3);
    CHECK(report.at("holes") == 1);
    CHECK(report.at("open_contours") == 1);
    CHECK(report.at("flat_contours") == 0);
    CHECK(report.at("overruled_contours") == 0);
    CHECK(report.at("grid_mm") == 0.5);
    CHECK(report.at("box_mm").at("max") == json({10, 10, 10}));
    CHECK(report.at("solid_volume_mm3") == 0.5 * (100 - 16));
    CHECK(report.at("frame") == json({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}));
}

TEST_CASE("report: times, memory, files and warnings as they were given", "[write]") {
    SliceResult result = write_test::square_with_hole();
    result.summary.triangles = 38142;
    result.summary.degenerate = 2;
    result.summary.threads = 8;
    result.summary.bands = 5;
    result.summary.ms = {.bucket = 1, .sweep = 2, .contours = 3, .nesting = 4};
    const json report = report_of(result, {.mesh_file = "liver.stl",
                                           .output_file = "",
                                           .read_ms = 5,
                                           .parse_ms = 6,
                                           .write_ms = 7,
                                           .total_ms = 28,
                                           .peak_rss_bytes = 1 << 30,
                                           .warnings = {"one", "two"}});
    CHECK(report.at("ms") == json({{"read", 5},
                                   {"parse", 6},
                                   {"bucket", 1},
                                   {"sweep", 2},
                                   {"contours", 3},
                                   {"nesting", 4},
                                   {"write", 7},
                                   {"total", 28}}));
    CHECK(report.at("triangles") == 38142);
    CHECK(report.at("degenerate") == 2);
    CHECK(report.at("threads") == 8);
    CHECK(report.at("bands") == 5);
    CHECK(report.at("peak_rss_bytes") == 1 << 30);
    CHECK(report.at("mesh") == "liver.stl");
    CHECK(report.at("output") == nullptr);
    CHECK(report.at("warnings") == json({"one", "two"}));
}

TEST_CASE("report: the hash is the result's, in sixteen digits", "[write]") {
    const SliceResult result = write_test::square_with_hole();
    const auto digits = report_of(result).at("output_hash").get<std::string>();
    CHECK(digits.size() == 16);
    CHECK(std::stoull(digits, nullptr, 16) == output_hash(result));
}

TEST_CASE("report: every kind of plan says what it was", "[write]") {
    SliceResult result = write_test::square_with_hole();
    SECTION("uniform") {
        result.plan.spacing = UniformLayers{.layer_height_mm = 0.032, .first_height_mm = 0.008, .datum = Datum::zero};
        const json plan = report_of(result).at("plan");
        CHECK(plan.at("kind") == "uniform");
        CHECK(plan.at("layer_height_mm") == 0.032);
        CHECK(plan.at("first_height_mm") == 0.008);
        CHECK(plan.at("datum") == "zero");
        CHECK(plan.at("side") == "below");
        CHECK(plan.at("rule").get<std::string>().find("one grid unit down") != std::string::npos);
    }
    SECTION("uniform, first plane in the middle") {
        CHECK(report_of(result).at("plan").at("first_height_mm") == nullptr);
        CHECK(report_of(result).at("plan").at("datum") == "mesh-min");
    }
    SECTION("explicit") {
        result.plan = {ExplicitPlanes{{1, 2, 5}}, Side::above};
        const json plan = report_of(result).at("plan");
        CHECK(plan.at("kind") == "explicit");
        CHECK(plan.at("heights") == 3);
        CHECK(plan.at("side") == "above");
    }
    SECTION("random") {
        result.plan.spacing = RandomLayers{.min_height_mm = 0.016, .max_height_mm = 0.032, .seed = 77};
        const json plan = report_of(result).at("plan");
        CHECK(plan.at("kind") == "random");
        CHECK(plan.at("min_height_mm") == 0.016);
        CHECK(plan.at("max_height_mm") == 0.032);
        CHECK(plan.at("seed") == 77);
    }
}

TEST_CASE("report: a file name that is not UTF-8 or holds quotes still gives JSON", "[write]") {
    const json report = report_of(write_test::square_with_hole(), {.mesh_file = "a\xff\"b\n.stl"});
    CHECK(report.at("mesh") == "a\xef\xbf\xbd\"b\n.stl");
}
