// Closing the layers of real meshes against dilating and eroding everything.
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "models_shared/real_meshes.hpp"

namespace {

regions::Polygons layer_of(const lamella::SliceResult& result, const lamella::Layer& layer) {
    regions::Polygons rings;
    for (const lamella::Contour& contour : result.contours_of(layer)) {
        if (contour.role == lamella::Role::outer || contour.role == lamella::Role::hole) {
            const auto points = result.points_of(contour);
            rings.emplace_back(points.begin(), points.end());
        }
    }
    return rings;
}

}  // namespace

TEST_CASE("closing agrees with closing everything on layers of real meshes", "[closing]") {
    const double radius_mm = GENERATE(0.049, 0.4);
    double worst = 0;
    for (const std::filesystem::path& file : real_meshes()) {
        const lamella::SliceResult result = sliced(soup_of(file), uniform(6));
        lamella::RegionRules rules;
        rules.fill_rule = lamella::FillRule::non_zero;
        for (const lamella::Layer& layer : result.layers) {
            const regions::Polygons rings = layer_of(result, layer);
            if (rings.empty()) {
                continue;
            }
            INFO(file << " at " << layer.plane_mm << " mm, radius " << radius_mm << " mm");
            rules.close_mm = 0;
            const auto plain = regions::region(rings, rules, result.unit_mm);
            rules.close_mm = radius_mm;
            const auto made = regions::region(rings, rules, result.unit_mm);
            const auto everywhere = regions::closed_everywhere(rings, rules, result.unit_mm);
            REQUIRE((plain.ok() && made.ok() && everywhere.ok()));
            CHECK(regions::broken_promise(*made) == "");
            const double difference = regions::difference_of(*made, *everywhere) * result.unit_mm;
            const double perimeter = regions::perimeter_of(regions::rings_of(*plain));
            CHECK(difference <= 5e-6 * perimeter);
            worst = std::max(worst, difference / perimeter);
        }
    }
    INFO("at most " << worst << " mm times the perimeter");
    CHECK(worst > 0);
}
