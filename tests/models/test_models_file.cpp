// Generated files hold what make_soup() gives, and no half-written file is left. Their bytes: tests/golden.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>

#include <catch2/catch.hpp>

#include "models/models.hpp"
#include "temp_folder.hpp"

namespace lamella::models::test {

TEST_CASE("a file holds the triangles that make_soup gives, and unit normals", "[models]") {
    const TempFolder folder;
    Recipe recipe;
    recipe.triangles = 5000;
    recipe.order = GENERATE(Order::z, Order::random);
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
    const TempFolder folder;
    Recipe recipe;
    recipe.triangles = 20'000;
    recipe.shape = GENERATE(Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism);
    const auto refuses = [&](const Recipe& bad) {
        const auto written = write_stl(bad, folder / "mesh.stl");
        return !written && written.error().code == ErrorCode::invalid_argument && !written.error().message.empty() &&
               make_soup(bad).empty() && folder.names().empty();
    };
    for (const std::uint64_t triangles : {std::uint64_t{0}, fewest_triangles - 1, most_triangles + 1}) {
        Recipe bad = recipe;
        bad.triangles = triangles;
        CHECK(refuses(bad));
    }
    for (const double length : {0.0, -1.0, 1e7, std::numeric_limits<double>::quiet_NaN()}) {
        Recipe bad = recipe;
        bad.height_mm = length;
        CHECK(refuses(bad));
        bad = recipe;
        bad.width_mm = length;
        CHECK(refuses(bad));
        bad = recipe;
        bad.segments = 200'000;
        bad.layer_height_mm = length;
        CHECK(refuses(bad));
    }
    for (const std::uint64_t segments : {std::uint64_t{0}, std::uint64_t{10}, std::uint64_t{1} << 60}) {
        Recipe bad = recipe;
        bad.segments = segments;
        CHECK(refuses(bad));
    }
}

TEST_CASE("the error for a file that cannot be written names the file", "[models]") {
    const TempFolder folder;
    Recipe recipe;
    recipe.triangles = 1000;
    const auto path = folder / "absent" / "mesh.stl";
    const auto written = write_stl(recipe, path);
    REQUIRE_FALSE(written.ok());
    CHECK(written.error().code == ErrorCode::unwritable_file);
    CHECK(written.error().message.find(path.string()) != std::string::npos);

    std::filesystem::create_directories(folder / "folder.stl" / "inside");
    CHECK_FALSE(write_stl(recipe, folder / "folder.stl").ok());
    CHECK(folder.names().size() == 1);
}

TEST_CASE("a stopped writer leaves no file", "[models]") {
    const TempFolder folder;
    Recipe recipe;
    recipe.triangles = 5000;
    recipe.order = GENERATE(Order::z, Order::random);
    const auto stop = []() noexcept { return true; };
    const auto written = write_stl(recipe, folder / "mesh.stl", stop);
    REQUIRE_FALSE(written.ok());
    CHECK(written.error().code == ErrorCode::cancelled);
    CHECK(folder.names().empty());
}

}  // namespace lamella::models::test
