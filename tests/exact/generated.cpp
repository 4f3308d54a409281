// Random closed meshes, sliced by the engine and in exact arithmetic. The long test runs the short one on thousands of
// seeds.
#include <algorithm>
#include <cstdlib>
#include <functional>
#include <span>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "exact/judge.hpp"
#include "exact/meshes.hpp"
#include "models/models.hpp"

using exact::Soup;
using lamella::models::Shape;

namespace {

constexpr std::uint64_t few_seeds = 6;
constexpr std::uint64_t many_seeds = 200;
constexpr std::size_t few_planes = 6;
constexpr std::size_t many_planes = 40;

struct Kind {
    const char* name;
    double grid_mm;
    std::function<Soup(std::uint64_t seed, bool large)> make;
    bool contradictory = false;  ///< some facets' orientations contradict each other
};

constexpr double fine = lamella::default_grid_mm;

auto generator(Shape shape) {
    return [shape](std::uint64_t seed, bool large) { return generated(shape, large ? 20'000 : 2'000, seed); };
}

const std::vector<Kind>& kinds() {
    static const std::vector<Kind> all{
        {"hull on a coarse grid", coarse_unit_mm,
         [](std::uint64_t seed, bool large) { return exact::hull(seed, large ? 400 : 60, 8 + seed % 50); }},
        {"hull at the edge of the grid", fine,
         [](std::uint64_t seed, bool large) {
             return shapes::moved(shapes::scaled(exact::hull(seed, large ? 400 : 60, 1U << 20), {0x1p-14, 0x1p-14, 0x1p-14}),
                                  {-950, 950, 950});
         }},
        {"gyroid", fine, generator(Shape::gyroid)},
        {"bone", fine, generator(Shape::bone)},
        {"torus", fine, generator(Shape::torus)},
        {"shells", fine, [](std::uint64_t seed, bool large) { return exact::shells(seed, large ? 7 : 4); }},
        {"needles", fine, [](std::uint64_t seed, bool large) { return exact::needles(seed, large ? 20 : 8, 0.01); }},
        {"needles as thin as the grid", fine,
         [](std::uint64_t seed, bool large) { return exact::needles(seed, large ? 20 : 8, 0x1p-17); }, true},
        {"crossing hulls, some inside out", fine,
         [](std::uint64_t seed, bool large) { return exact::crossing_hulls(seed, large ? 30 : 8); }, true},
        {"cells that touch", coarse_unit_mm,
         [](std::uint64_t seed, bool large) { return exact::cells(seed, large ? 12 : 4); }},
    };
    return all;
}

struct Tally {
    std::size_t meshes = 0;
    std::size_t layers = 0;
    std::size_t contours = 0;
    std::size_t points = 0;
};

/// Number of contours whose role contradicts their facets. Skips contours so small that rounding their points can reverse
/// them, as just below the tip of a needle.
std::ptrdiff_t count_overruled(const lamella::SliceResult& result) {
    return std::count_if(result.contours.begin(), result.contours.end(), [&](const lamella::Contour& contour) {
        const std::span<const lamella::Point> points = result.points_of(contour);
        std::int64_t length = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const lamella::Point to = points[i + 1 < points.size() ? i + 1 : 0];
            length += std::abs(std::int64_t{to.x} - points[i].x) + std::abs(std::int64_t{to.y} - points[i].y);
        }
        const bool small = contour.twice_area.high == 0 && contour.twice_area.low <= static_cast<std::uint64_t>(length);
        return (contour.flags & lamella::orientation_overruled) != 0 && !small;
    });
}

/// Slices through heights of vertices and judges every layer.
void judge(const Kind& kind, std::uint64_t seed, bool large, std::size_t planes, Tally& tally) {
    const Soup soup = kind.make(seed, large);
    INFO(kind.name << ", seed " << seed);
    const lamella::SliceResult result =
        sliced(soup, exact::through_vertices(soup, kind.grid_mm, seed, planes), {}, exact::form_of(seed));
    CHECK(result.info.open_contours == 0);
    CHECK((kind.contradictory || count_overruled(result) == 0));
    REQUIRE_THAT(exact::difference(result, oracle::quantise(soup, kind.grid_mm)), Catch::Equals(""));
    ++tally.meshes;
    tally.layers += result.layers.size();
    tally.contours += result.contours.size();
    tally.points += result.points.size();
}

}  // namespace

TEST_CASE("contours of random closed meshes equal the exact ones", "[meshes]") {
    Tally tally;
    for (const Kind& kind : kinds()) {
        for (std::uint64_t seed = 0; seed < few_seeds; ++seed) {
            judge(kind, seed, false, few_planes, tally);
        }
    }
    CHECK(tally.points > 1'000 * few_seeds);
}

TEST_CASE("contours of thousands of random closed meshes equal the exact ones", "[meshes_long]") {
    Tally tally;
    for (const Kind& kind : kinds()) {
        for (std::uint64_t seed = 100; seed < 100 + many_seeds; ++seed) {
            const bool large = seed % 4 == 0;
            judge(kind, seed, large, large ? few_planes : many_planes, tally);
        }
    }
    WARN("judged " << tally.meshes << " meshes, " << tally.layers << " layers, " << tally.contours << " contours, "
                   << tally.points << " points");
}

TEST_CASE("the exact judge finds every kind of difference", "[meshes]") {
    const Soup soup = exact::shells(5, 2);
    const std::vector<oracle::Triangle> triangles = oracle::quantise(soup, fine);
    const lamella::SliceOptions options = exact::through_vertices(soup, fine, 5, few_planes);
    const auto differs = [&](auto&& damage) {
        lamella::SliceResult result = sliced(soup, options, {}, exact::form_of(5));
        damage(result);
        return !exact::difference(result, triangles).empty();
    };
    CHECK_FALSE(differs([](lamella::SliceResult&) {}));
    CHECK(differs([](lamella::SliceResult& r) { r.points[3].x += 1; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[1].role = lamella::Role::flat; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[0].parent = 0; }));
    CHECK(differs([](lamella::SliceResult& r) { ++r.contours[0].segments; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[0].twice_area.low ^= 2; }));
    CHECK(differs([](lamella::SliceResult& r) {
        const auto filled = [](const lamella::Layer& layer) { return layer.contour_count > 0; };
        --std::find_if(r.layers.begin(), r.layers.end(), filled)->contour_count;
    }));
}
