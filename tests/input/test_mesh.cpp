// Meshes in memory: transforms, what is counted of them, and welding: which vertices become one. That nothing else changes:
// tests/golden.
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>

#include "engine/slicing.hpp"
#include "lamella/check.hpp"
#include "lamella/weld.hpp"

namespace lamella {
namespace {

using shapes::Soup;

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST_CASE("axis normals give exact transforms, that of z the identity", "[input]") {
    CHECK(Transform::from_normal(0, 0, -2).m == std::array<double, 12>{1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0});
    CHECK(Transform::from_normal(5, 0, 0).m == std::array<double, 12>{0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0});
    CHECK(Transform::from_normal(0, 0, 1).is_identity());
    CHECK(Transform::from_normal(0, 0, 1e-300).is_identity());
    CHECK(Transform::from_normal(0, -0.0, 7e300).is_identity());
    const Transform z = Transform::from_normal(-0.0, 0, 3);
    CHECK(std::none_of(z.m.begin(), z.m.end(), [](double entry) { return std::signbit(entry); }));
}

TEST_CASE("any normal is turned into +z by a proper rotation", "[input]") {
    std::mt19937 random(1);
    for (int draw = 0; draw < 300; ++draw) {
        // Along axes, between them and nearly so, of any length.
        std::array<double, 3> n{};
        for (double& entry : n) {
            entry = std::array{0.0, 0.0, 1.0, -1.0, 0.3, 1e-9, -1e-12}[random() % 7];
        }
        n[random() % 3] = 1 - 2 * double(random() % 2);
        const double length = std::hypot(n[0], n[1], n[2]);
        const double scale = std::array{1.0, 1e-200, 1e300}[random() % 3];
        const Transform turn = Transform::from_normal(n[0] * scale, n[1] * scale, n[2] * scale);
        const auto row = [&](std::size_t i) { return std::array{turn.m[4 * i], turn.m[4 * i + 1], turn.m[4 * i + 2]}; };
        const auto dot = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
        CAPTURE(n, scale);
        for (std::size_t i = 0; i < 3; ++i) {
            CHECK(dot(row(i), n) == Approx(i == 2 ? length : 0).epsilon(1e-15).margin(2e-15));
            CHECK(turn.m[4 * i + 3] == 0);
            for (std::size_t j = 0; j < 3; ++j) {
                CHECK(dot(row(i), row(j)) == Approx(i == j ? 1 : 0).margin(2e-15));
            }
        }
        const auto [x, y, z] = std::array{row(0), row(1), row(2)};
        CHECK(x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0]) + x[2] * (y[0] * z[1] - y[1] * z[0]) >
              0);
    }
}

TEST_CASE("a product of transforms applies the right one first", "[input]") {
    const Transform move{{1, 0, 0, 10, 0, 1, 0, 20, 0, 0, 1, 30}};
    const Transform turn{{0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}};
    CHECK((turn * move).m == std::array<double, 12>{0, -1, 0, -20, 1, 0, 0, 10, 0, 0, 1, 30});
    CHECK((move * turn).m == std::array<double, 12>{0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30});
    CHECK((move * Transform::scale(2)).m == std::array<double, 12>{2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 2, 30});
    CHECK((move * Transform{}).m == move.m);
}

// --- Counts

/// Twelve triangles, outward.
Soup cube_at(double low, double size) {
    return shapes::box({low, low, low}, {low + size, low + size, low + size});
}

TEST_CASE("edges, shells and volumes of small meshes are counted", "[input]") {
    const Soup whole = cube_at(0, 2);
    const auto beside = [&](shapes::Xyz by) { return shapes::joined({whole, shapes::moved(whole, by)}); };
    Soup flipped_patch = whole;
    std::copy_n(shapes::flipped(whole).begin(), 18, flipped_patch.begin());
    // A corner leaves its place by a third of the step between vertices of the default grid.
    Soup collapsed = shapes::joined({whole, shapes::triangle({0, 0, 0}, {0, 0, 1e-8}, {2, 0, 0})});
    collapsed[9 * 3 + 3] += 3e-7;
    struct Case {
        const char* name;
        Soup soup;
        std::uint64_t edges, boundary, overfull, mismatched, shells;
        bool closed;
        double volume_mm3;
    };
    const std::vector<Case> cases = {
        {"a cube", whole, 18, 0, 0, 0, 1, true, 8},
        {"inverted", shapes::flipped(whole), 18, 0, 0, 0, 1, true, -8},
        {"without a triangle", shapes::without(whole, 11, 1), 18, 3, 0, 0, 1, false, 0},
        {"two that share an edge", beside({2, 2, 0}), 35, 0, 1, 0, 1, true, 16},
        {"two that share a vertex", beside({2, 2, 2}), 36, 0, 0, 0, 2, true, 16},
        {"two that share a side", beside({2, 0, 0}), 32, 0, 4, 0, 1, true, 16},
        {"two apart", beside({5, 0, 0}), 36, 0, 0, 0, 2, true, 16},
        {"with a face twice", shapes::joined({whole, shapes::only(whole, 0, 1)}), 18, 0, 3, 0, 1, false, 0},
        {"with a flipped patch", flipped_patch, 18, 0, 0, 4, 1, false, 0},
        {"with a collapsed triangle", collapsed, 18, 0, 0, 0, 1, true, 8},
    };
    for (const Case& one : cases) {
        for (const int threads : {1, 3}) {
            INFO(one.name << ", " << threads << " threads");
            const MeshCheck counts = value_of(check(view_of(one.soup), {.counts_only = true}, {.threads = threads}));
            CHECK(counts.triangles == one.soup.size() / 9);
            CHECK(counts.degenerate == (one.soup == collapsed ? 1 : 0));
            CHECK(counts.edges == one.edges);
            CHECK(counts.boundary_edges == one.boundary);
            CHECK(counts.overfull_edges == one.overfull);
            CHECK(counts.mismatched_edges == one.mismatched);
            CHECK(counts.shell_count == one.shells);
            CHECK(counts.closed == one.closed);
            CHECK((!one.closed || counts.volume_mm3 == Approx(one.volume_mm3)));
            CHECK((!one.closed || counts.area_mm2 == Approx(3 * std::abs(one.volume_mm3))));
        }
    }
}

TEST_CASE("beyond 1,024 mm the unit doubles", "[input]") {
    const auto grid_of = [](const Soup& soup, double grid_mm = 0) {
        return value_of(check(view_of(soup), {.frame = {.grid_mm = grid_mm}, .counts_only = true})).grid_mm;
    };
    CHECK(grid_of(cube_at(0, 1024)) == default_grid_mm);
    CHECK(grid_of(cube_at(0, 1025)) == 2 * default_grid_mm);
    CHECK(grid_of(cube_at(-1e9, 1e6)) == 1.0);
    CHECK(grid_of(cube_at(0, 2), 0.25) == 0.25);
}

TEST_CASE("meshes that cannot be counted or welded are refused with the triangle", "[input][weld]") {
    const auto refused = [](const MeshView& mesh) {
        const Error error = error_of(check(mesh, {.counts_only = true}));
        CHECK(weld(mesh, 0.1).error().code == error.code);
        return error;
    };
    CHECK(refused({}).code == ErrorCode::empty_mesh);

    for (const double value : {std::nan(""), infinity, -infinity, 3e38, -1.1e9}) {
        Soup soup = shapes::octasphere({0, 0, 0}, 10, 6);
        soup[9 * 20'000 + 7] = value;
        soup[9 * 25'000] = value;
        const Error error = error_of(check(view_of(soup), {.counts_only = true}));
        CHECK(error.code == ErrorCode::bad_coordinate);
        CHECK(error.triangle == 20'000);
        CHECK_THAT(error.message, Catch::Contains("triangle 20000"));
        CHECK((std::isfinite(value) || error_of(weld(view_of(soup), 0.1)).triangle == 20'000));
    }
    const std::vector<float> xyz(9);
    const std::vector<std::uint32_t> indices = {0, 1, 2, 0, 1, 3};
    const Error beyond = refused(MeshView::indexed(std::span<const float>(xyz), indices));
    CHECK(beyond.code == ErrorCode::invalid_argument);
    CHECK(beyond.triangle == 1);
    // No corner is read with the one before it: the vertex lies far outside the memory.
    const std::vector<std::uint32_t> far{0, 1, 0xfffffff0};
    const MeshView of_integers{
        .vertices = xyz.data(), .vertex_count = 3, .triangle_count = 1, .indices = far.data(), .vertex_type = Number::i32};
    CHECK(refused(of_integers).code == ErrorCode::invalid_argument);
    const Soup soup = cube_at(0, 2);
    for (const double unit : {-2.0, std::nan(""), 1e-12}) {
        CHECK_FALSE(check(view_of(soup), {.frame = {.grid_mm = unit}, .counts_only = true}).ok());
    }
    for (const double tolerance : {-1.0, 1e-10, std::nan(""), infinity}) {
        CHECK(weld(view_of(soup), tolerance).error().code == ErrorCode::invalid_argument);
    }
}

// --- Welding

TEST_CASE("a cracked sphere closes when it is welded", "[input][weld]") {
    const Soup whole = shapes::octasphere({0, 0, 0}, 10, 4);
    const WeldedMesh exact = value_of(weld(view_of(whole), 0));
    CHECK(exact.joined == 0);
    CHECK(exact.largest_move_mm == 0);
    CHECK(sliced(exact.view(), uniform(0.3)).hash() == sliced(whole, uniform(0.3)).hash());
    Soup soup = whole;
    std::mt19937 random(5);
    for (double& coordinate : soup) {
        coordinate += std::uniform_real_distribution<double>(-0.001, 0.001)(random);
    }
    CHECK(sliced(soup, uniform(0.3)).info.open_contours > 0);
    const WeldedMesh mesh = value_of(weld(view_of(soup), 0.01));
    CHECK(mesh.vertex_count == whole.size() / 9 / 2 + 2);
    CHECK(mesh.joined == soup.size() / 3 - mesh.vertex_count);
    CHECK(mesh.largest_move_mm <= 0.01);
    CHECK(mesh.largest_move_mm > 0.001);
    const SliceResult result = sliced(mesh.view(), uniform(0.3));
    CHECK(result.info.open_contours == 0);
    CHECK(result.info.degenerate == 0);
}

using Corner = std::array<double, 3>;

double squared_distance(const Corner& a, const Corner& b) {
    return std::pow(a[0] - b[0], 2) + std::pow(a[1] - b[1], 2) + std::pow(a[2] - b[2], 2);
}

template <class Number>
std::vector<Number> numbers_of(const std::vector<Corner>& corners) {
    std::vector<Number> numbers;
    for (const Corner& at : corners) {
        numbers.insert(numbers.end(), {Number(at[0]), Number(at[1]), Number(at[2])});
    }
    return numbers;
}

/// Against the rule as stated, all corners against all, whatever their order.
template <class Number>
void check_weld(const std::vector<Corner>& corners, double tolerance) {
    const std::vector<Number> soup = numbers_of<Number>(corners);
    const WeldedMesh mesh = value_of(weld(MeshView::soup(std::span<const Number>(soup)), tolerance));
    std::vector<Corner> sorted = corners;
    std::sort(sorted.begin(), sorted.end());
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    std::vector<Corner> kept;
    std::map<Corner, std::uint32_t> vertex_of;
    double largest_move = 0;
    for (const Corner& at : sorted) {
        const auto nearest = std::min_element(kept.begin(), kept.end(), [&](const Corner& a, const Corner& b) {
            return squared_distance(at, a) < squared_distance(at, b);
        });
        vertex_of[at] = static_cast<std::uint32_t>(nearest - kept.begin());
        if (nearest == kept.end() || squared_distance(at, *nearest) > tolerance * tolerance) {
            vertex_of[at] = static_cast<std::uint32_t>(kept.size());
            kept.push_back(at);
        } else {
            largest_move = std::max(largest_move, squared_distance(at, *nearest));
        }
    }
    REQUIRE(mesh.vertex_count == kept.size());
    CHECK(mesh.joined == sorted.size() - kept.size());
    CHECK(mesh.largest_move_mm == std::sqrt(largest_move));
    REQUIRE(mesh.coordinates.size() == kept.size() * 3 * sizeof(Number));
    const std::vector<Number> numbers = numbers_of<Number>(kept);
    CHECK(std::memcmp(mesh.coordinates.data(), numbers.data(), mesh.coordinates.size()) == 0);
    REQUIRE(mesh.indices.size() == corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
        CHECK(mesh.indices[i] == vertex_of[corners[i]]);
    }
    CHECK(value_of(weld(mesh.view(), tolerance)).joined == 0);
}

TEST_CASE("the nearest vertex wins, across cells of the search too", "[input][weld]") {
    std::mt19937 random(21);
    std::uniform_real_distribution<double> place(-3, 3);
    std::vector<Corner> corners(3 * 300);
    std::generate(corners.begin(), corners.end(), [&] { return Corner{place(random), place(random), place(random)}; });
    check_weld<double>(corners, 0.4);
    // Sixteenths, which are exact in either type, so that distances of exactly the tolerance are common.
    const auto near_integer = [&] { return int(random() % 9) - 4 + (random() % 4 == 0 ? double(random() % 5) / 16 : 0); };
    for (int draw = 0; draw < 300; ++draw) {
        corners.resize(3 * (1 + random() % 33));
        std::generate(corners.begin(), corners.end(), [&] {
            return Corner{near_integer(), near_integer(), near_integer()};
        });
        const double tolerance = double(random() % 40) / 16;
        draw % 2 == 0 ? check_weld<float>(corners, tolerance) : check_weld<double>(corners, tolerance);
    }
}

TEST_CASE("390,000 vertices in one cell of the search are welded", "[input][weld]") {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(0, 1);
    Soup soup(std::size_t{9} * 130'000);
    std::generate(soup.begin(), soup.end(), [&] { return place(random); });
    CHECK(value_of(weld(view_of(soup), 0)).vertex_count == 390'000);
    CHECK(value_of(weld(view_of(soup), 0.01)).vertex_count < 390'000);
}

}  // namespace
}  // namespace lamella
