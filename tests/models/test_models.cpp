// Generated meshes of every shape are what was asked for, and files hold them. The bytes of files: tests/golden; how writing
// fails or stops: tests/cli.
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include <catch2/catch.hpp>

#include "lamella/check.hpp"
#include "models/models.hpp"
#include "temp_folder.hpp"

namespace lamella::models::test {

namespace {

using std::numbers::pi;

MeshCheck counts_of(const std::vector<float>& soup) {
    const Result<MeshCheck> counted = check(MeshView::soup(soup), {.counts_only = true});
    REQUIRE(counted.ok());
    return *counted;
}

/// Two faces at each edge, which run opposite ways; vertices of neighbours are equal to the bit, and none collapses.
void check_closed(const std::vector<float>& soup) {
    const MeshCheck counted = counts_of(soup);
    CHECK(counted.closed);
    CHECK(counted.overfull_edges == 0);
    CHECK(counted.exact_boundary_edges == 0);
    CHECK(counted.degenerate == 0);
    CHECK(counted.volume_mm3 > 0);
}

std::array<float, 2> z_range(const float* triangle) {
    const auto [low, high] = std::minmax({triangle[2], triangle[5], triangle[8]});
    return {low, high};
}

/// Crossings of triangles with planes at (i + 1/2) layer heights above zero.
std::uint64_t crossings(const std::vector<float>& soup, double layer_height_mm) {
    double count = 0;
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        const auto [low, high] = z_range(&soup[t]);
        count += std::floor(static_cast<double>(high) / layer_height_mm - 0.5) -
                 std::floor(static_cast<double>(low) / layer_height_mm - 0.5);
    }
    return static_cast<std::uint64_t>(count);
}

/// Lowest vertices never descend from one triangle to the next.
bool ascending(const std::vector<float>& soup) {
    for (std::size_t t = 9; t < soup.size(); t += 9) {
        if (z_range(&soup[t])[0] < z_range(&soup[t - 9])[0]) {
            return false;
        }
    }
    return true;
}

auto any_shape() {
    return GENERATE(Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism);
}

std::string name_of(Shape shape) {
    return std::string(shape_names[static_cast<std::size_t>(shape)]);
}

#ifdef LAMELLA_TESTS_SANITIZED
constexpr std::uint64_t large_mesh = 120'000;  // the full size would take minutes
#else
constexpr std::uint64_t large_mesh = 600'000;
#endif

}  // namespace

TEST_CASE("every shape of every size is closed, oriented and has the requested triangles", "[models]") {
    const Shape shape = any_shape();
    const auto triangles = GENERATE(as<std::uint64_t>{}, 100, 101, 334, 1000, 4321, 20'000, large_mesh);
    const auto seed = GENERATE(as<std::uint64_t>{}, 1, 7);
    CAPTURE(name_of(shape), triangles, seed);
    const std::vector<float> soup = make_soup({.shape = shape, .triangles = triangles, .seed = seed});
    CHECK(soup.size() / 9 == triangles / 2 * 2);
    check_closed(soup);
    CHECK(ascending(soup));
}

TEST_CASE("volumes are near those of the ideal bodies", "[models]") {
    const auto seed = GENERATE(as<std::uint64_t>{}, 1, 2, 3);
    const auto volume = [&](Shape shape, std::optional<double> width_mm = {}) {
        const Recipe recipe{.shape = shape, .triangles = 60'000, .height_mm = 40, .width_mm = width_mm, .seed = seed};
        return counts_of(make_soup(recipe)).volume_mm3;
    };
    CHECK(volume(Shape::sphere) == Approx(4 * pi / 3 * 20 * 20 * 20).epsilon(0.002));
    CHECK(volume(Shape::sphere, 10) == Approx(4 * pi / 3 * 20 * 5 * 5).epsilon(0.002));
    CHECK(volume(Shape::prism, 10) == Approx(pi * 5 * 5 * 40).epsilon(1e-5));
    CHECK(volume(Shape::torus) == Approx(2 * pi * pi * 18 * 5.6 * 5.6).epsilon(0.01));
}

TEST_CASE("a mesh has the requested height and width", "[models]") {
    const Shape shape = any_shape();
    CAPTURE(name_of(shape));
    const std::vector<float> soup = make_soup({.shape = shape, .triangles = 40'000, .height_mm = 12, .width_mm = 30});
    const auto [low, high] = counts_of(soup).box;
    CHECK(low[2] == Approx(0).margin(0.2));
    CHECK(high[2] == Approx(12).margin(0.2));
    // The tilted torus has the requested width only in some directions around z.
    CHECK(high[0] - low[0] <= 30.1);
    CHECK(high[0] - low[0] >= (shape == Shape::torus ? 20 : 28.5));
}

TEST_CASE("the number of crossings is met within 5 %", "[models]") {
    const Shape shape = any_shape();
    // Fractions of the shape's natural number of crossings, which is the maximum for a prism.
    const double factor = shape == Shape::bone ? GENERATE(0.3, 0.97, 1.4) : GENERATE(0.3, 0.6, 0.97);
    CAPTURE(name_of(shape), factor);
    Recipe recipe{.shape = shape, .triangles = 50'000, .height_mm = 60, .layer_height_mm = 0.05};
    const auto natural = static_cast<double>(crossings(make_soup(recipe), recipe.layer_height_mm));
    recipe.segments = static_cast<std::uint64_t>(natural * factor);
    const std::vector<float> soup = make_soup(recipe);
    REQUIRE(soup.size() / 9 == recipe.triangles);
    CHECK(static_cast<double>(crossings(soup, recipe.layer_height_mm)) == Approx(natural * factor).epsilon(0.05));
    check_closed(soup);
    CHECK(ascending(soup));
}

TEST_CASE("a file holds the triangles that make_soup gives, and unit normals", "[models]") {
    const TempFolder folder;
    const Recipe recipe{.triangles = 5000, .order = GENERATE(Order::z, Order::random)};
    REQUIRE(write_stl(recipe, folder / "a.stl").ok());
    REQUIRE(write_stl(recipe, folder / "b.stl").ok());
    CHECK(folder.names().size() == 2);
    const std::string bytes = bytes_of(folder / "a.stl");
    CHECK(bytes == bytes_of(folder / "b.stl"));

    const std::vector<float> soup = make_soup(recipe);
    REQUIRE(bytes.size() == 84 + 50 * soup.size() / 9);
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    CHECK(count == soup.size() / 9);
    for (std::size_t t = 0; t < count; ++t) {
        std::array<float, 12> record{};
        std::memcpy(record.data(), bytes.data() + 84 + 50 * t, sizeof record);
        REQUIRE(std::equal(record.begin() + 3, record.end(), &soup[9 * t]));
        const auto [x, y, z] = std::array<float, 3>{record[0], record[1], record[2]};
        REQUIRE(x * x + y * y + z * z == Approx(1).epsilon(1e-5));
    }
}

TEST_CASE("an invalid recipe is refused and leaves no file", "[models]") {
    constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
    const Shape shape = any_shape();
    const TempFolder folder;
    const auto refuses = [&](auto&& spoil) {
        Recipe bad{.shape = shape, .triangles = 20'000};
        spoil(bad);
        const auto written = write_stl(bad, folder / "mesh.stl");
        return !written && written.error().code == ErrorCode::invalid_argument && make_soup(bad).empty() &&
               folder.names().empty();
    };
    for (const std::uint64_t triangles : {std::uint64_t{0}, fewest_triangles - 1, most_triangles + 1}) {
        CHECK(refuses([&](Recipe& bad) { bad.triangles = triangles; }));
    }
    for (const double length : {0.0, -1.0, 1e7, no_number}) {
        CHECK(refuses([&](Recipe& bad) { bad.height_mm = length; }));
        CHECK(refuses([&](Recipe& bad) { bad.width_mm = length; }));
        CHECK(refuses([&](Recipe& bad) {
            bad.segments = 200'000;
            bad.layer_height_mm = length;
        }));
    }
    for (const std::uint64_t segments : {std::uint64_t{0}, std::uint64_t{10}, std::uint64_t{1} << 60}) {
        CHECK(refuses([&](Recipe& bad) { bad.segments = segments; }));
    }
}

}  // namespace lamella::models::test
