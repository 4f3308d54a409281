// Real meshes, as they are and made rough, with simplified contours: valid, with fewer points, and without more crossings.
#include <cmath>

#include "engine/slicing.hpp"
#include "models_shared/real_meshes.hpp"

namespace {

/// Corners moved by up to `mm`, equal ones alike.
shapes::Soup roughened(shapes::Soup soup, double mm) {
    for (double& coordinate : soup) {
        coordinate += mm * std::sin(coordinate * 7919);
    }
    return soup;
}

std::uint64_t crossings_of(const lamella::SliceResult& result) {
    const auto crossings = find_crossings(result);
    REQUIRE(crossings.ok());
    return crossings->count;
}

}  // namespace

TEST_CASE("simplified layers of real meshes are valid and cross no more", "[simplify]") {
    std::size_t before = 0;
    std::size_t after = 0;
    for (const std::filesystem::path& file : real_meshes()) {
        const shapes::Soup soup = soup_of(file);
        for (const double rough_mm : {0.0, 0.3}) {
            const shapes::Soup rough = roughened(soup, rough_mm);
            for (const lamella::FillRule rule : {lamella::FillRule::contours, lamella::FillRule::non_zero}) {
                lamella::SliceOptions options = uniform(3);
                options.region.fill_rule = rule;
                options.origins = true;
                const lamella::SliceResult plain = sliced(rough, options);
                for (const double tolerance_mm : {0.02, 1.0}) {
                    INFO(file << ", rough by " << rough_mm << " mm, " << name_of(rule) << ", within " << tolerance_mm);
                    options.region.simplify_mm = tolerance_mm;
                    const lamella::SliceResult simplified = sliced(rough, options);
                    const lamella::Status valid = validate(simplified, view_of(rough));
                    INFO((valid ? std::string() : valid.error().message));
                    REQUIRE(valid.ok());
                    REQUIRE(simplified.contours.size() == plain.contours.size());
                    REQUIRE(crossings_of(simplified) <= crossings_of(plain));
                    before += plain.points.size();
                    after += simplified.points.size();
                }
            }
        }
    }
    CHECK(after < before / 2);
}
