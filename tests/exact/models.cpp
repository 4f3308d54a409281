// Real meshes, sliced by the engine and in exact arithmetic, at few planes, half of them at heights of vertices. Regions of
// real layers, alone and laid over moved copies of themselves, judged in exact arithmetic.
#include <array>
#include <random>

#include "engine/slicing.hpp"
#include "exact/judge.hpp"
#include "lamella/check.hpp"
#include "models_shared/real_meshes.hpp"

using lamella::FillRule;
using regions::Polygons;

namespace {

/// The closed contours of layers spread over a mesh.
std::vector<Polygons> layers_of(const std::filesystem::path& file, std::size_t count) {
    const shapes::Soup soup = soup_of(file);
    const lamella::Box box = check(view_of(soup), {.counts_only = true}).value().box;
    std::vector<Polygons> layers(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
        layers[i] = regions::rings_of(sliced(soup, at_heights({std::lerp(box.min_mm[2], box.max_mm[2], share)}, 0)));
    }
    return layers;
}

void add_moved(Polygons& polygons, const Polygons& more, regions::Point by) {
    for (regions::Polygon polygon : more) {
        for (regions::Point& point : polygon) {
            point = {point.x + by.x, point.y + by.y};
        }
        polygons.push_back(std::move(polygon));
    }
}

void judge(const Polygons& polygons, FillRule rule, std::mt19937& random) {
    const lamella::RegionRules rules{.fill_rule = rule};
    const lamella::SliceResult found = regions::region_of(polygons, rules);
    INFO(lamella::name_of(rule));
    REQUIRE(regions::fault_in(found) == "");
    REQUIRE(exact::fault_in_region(polygons, rule, found) == "");
    REQUIRE(regions::dependence_on_order(polygons, rules, found, random) == "");
}

void judge_layers(std::size_t count) {
    // From copies that lie within rounding to those that lie some mm away.
    constexpr std::array<regions::Point, 6> moves{
        {{0, 0}, {1, 0}, {3, -2}, {1'000, 777}, {50'000, -70'001}, {3'000'000, 1'000'001}}};
    constexpr std::array all{FillRule::even_odd, FillRule::non_zero, FillRule::positive};
    std::mt19937 random(8);
    std::size_t number = 0;
    for (const char* name : {"liver.stl", "brain.stl", "femur.stl"}) {
        for (const Polygons& layer : layers_of(folder / name, count)) {
            INFO(name << ", layer " << number);
            judge(layer, FillRule::non_zero, random);
            Polygons laid_over = layer;
            add_moved(laid_over, layer, moves[number % moves.size()]);
            judge(laid_over, all[number % all.size()], random);
            if (number % 4 == 0) {
                add_moved(laid_over, layer, moves[(number + 3) % moves.size()]);
                judge(laid_over, all[(number + 1) % all.size()], random);
            }
            ++number;
        }
    }
    CHECK(number == 3 * count);
}

}  // namespace

TEST_CASE("contours of real meshes equal the exact ones", "[models]") {
    for (const std::filesystem::path& file : real_meshes()) {
        INFO(file);
        const shapes::Soup soup = soup_of(file);
        const double grid_mm = check(view_of(soup), {.counts_only = true}).value().grid_mm;
        for (const std::uint64_t seed : {0U, 3U}) {
            const lamella::SliceResult result =
                sliced(soup, exact::through_vertices(soup, grid_mm, seed, 6), {}, exact::form_of(seed));
            INFO("seed " << seed);
            REQUIRE_THAT(exact::difference(result, oracle::quantise(soup, grid_mm)), Catch::Equals(""));
        }
    }
}

TEST_CASE("regions of real layers and of copies laid over each other are right", "[region_models]") {
    judge_layers(6);
}

TEST_CASE("regions of a hundred layers of each real mesh are right", "[region_models_long]") {
    judge_layers(100);
}
