// Meshes as callers hold them: soup or indexed, float, double or whole numbers, strided, transformed in double or in their
// own numbers. Vertices that are placed once give what their triangles give corner by corner.
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <tuple>

#include "engine/rounds.hpp"
#include "engine/slicing.hpp"
#include "slicing/buckets/mesh_source.hpp"

using namespace lamella;

namespace {

/// A box of 2 x 3 x 4 mm, away from the origin.
const shapes::Soup brick = shapes::box({1, 1, 1}, {3, 4, 5});

/// Vertices as numbers of any type, whole mm, so that every type holds the same.
template <class Number>
struct Mesh {
    std::vector<Number> xyz;
    std::vector<std::uint32_t> indices;

    MeshView view() const {
        constexpr bool wide = sizeof(Number) == 8;
        constexpr bool real = std::is_floating_point_v<Number>;
        constexpr lamella::Number type = real ? (wide ? lamella::Number::f64 : lamella::Number::f32)
                                              : (wide ? lamella::Number::i64 : lamella::Number::i32);
        return {.vertices = xyz.data(),
                .vertex_count = xyz.size() / 3,
                .triangle_count = indices.size() / 3,
                .indices = indices.data(),
                .vertex_type = type};
    }
    /// Three vertices of its own for each triangle.
    std::vector<Number> soup() const {
        std::vector<Number> numbers;
        for (const std::uint32_t index : indices) {
            numbers.insert(numbers.end(), xyz.begin() + 3 * index, xyz.begin() + 3 * index + 3);
        }
        return numbers;
    }
};

/// Triangles of vertices that lie close together; some vertices lie in one place, some triangles have a vertex twice.
template <class Number>
Mesh<Number> tangle(std::size_t vertices, std::size_t triangles, unsigned seed) {
    std::mt19937 random(seed);
    Mesh<Number> mesh;
    for (std::size_t v = 0; v < vertices; ++v) {
        const bool doubled = v > 0 && v % 13 == 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto fresh = static_cast<Number>(static_cast<std::int64_t>(random() % 64 + v / 4) - 40);
            mesh.xyz.push_back(doubled ? mesh.xyz[3 * (v - 1) + axis] : fresh);
        }
    }
    for (std::size_t t = 0; t < triangles; ++t) {
        const std::size_t near = random() % (vertices - 30);
        for (int corner = 0; corner < 3; ++corner) {
            mesh.indices.push_back(static_cast<std::uint32_t>(near + random() % 30));
        }
    }
    return mesh;
}

/// What a mesh gives, in whichever form it is held.
auto outcome_of(const MeshView& mesh, const SliceOptions& options = uniform(3), const Context& context = {}) {
    const SliceResult result = sliced(mesh, options, context);
    return std::tuple(result.hash(), result.info.degenerate, result.info.crossed, result.info.box);
}

template <class Number>
void check_against_soup() {
    const Mesh<Number> mesh = tangle<Number>(900, 20000, 5);
    REQUIRE(IndexedSource::pays_for(mesh.view()));
    const std::vector<Number> corners = mesh.soup();
    MeshView soup = mesh.view();
    soup.vertices = corners.data();
    soup.vertex_count = 0;
    soup.indices = nullptr;
    SliceOptions turned{.heights_mm = {{-11, 3, 3, 90, 17.25, 12, 1000}}};
    turned.frame.transform.m = {0.3, 0.7, -0.1, 4, 0.7, -0.3, 0.2, 0.1, 0.1, 0.2, 0.9, -2};
    SliceOptions as_numbers = turned;
    as_numbers.frame.as_mesh_numbers = true;
    for (SliceOptions options : {uniform(7), turned, as_numbers}) {
        for (const double grid_mm : {0.0, 0.001, 2.5}) {
            options.frame.grid_mm = grid_mm;
            INFO("grid " << grid_mm << ", as mesh numbers " << options.frame.as_mesh_numbers);
            const Context context{.threads = options.heights_mm ? 3 : 0};
            const auto expected = outcome_of(soup, options, context);
            CHECK((std::get<1>(expected) > 1000 && std::get<2>(expected) > 100));
            CHECK(outcome_of(mesh.view(), options, context) == expected);
        }
    }
}

TEST_CASE("every call applies the unit of a mesh", "[engine][views]") {
    const shapes::Soup doubled = shapes::scaled(brick, {2, 2, 2});
    shapes::Indexed shared = shapes::indexed(brick);
    MeshView soup = view_of(brick);
    MeshView indexed = shared.view();
    soup.mm_per_unit = indexed.mm_per_unit = 2;
    const SliceResult expected = sliced(doubled, uniform(0.5));
    const auto prepared = value_of(prepare(soup));
    const std::vector<Part> parts = {{.mesh = soup}};
    for (const Source& source : {Source(soup), Source(indexed), Source(prepared), Source(parts)}) {
        const SliceResult result = sliced(source, uniform(0.5));
        CHECK(result.hash() == expected.hash());
        CHECK(result.info.box == expected.info.box);
        CHECK(result.info.options.frame.transform.is_identity());
    }
    CHECK(value_of(check(soup)).box == expected.info.box);
    CHECK(value_of(check(indexed, {.counts_only = true})).volume_mm3 == 8 * 24);
    CHECK(value_of(audits::volume_of(expected, soup)).mesh_mm3 == 8 * 24);
    for (const double unit : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
        soup.mm_per_unit = unit;
        CHECK(failure_of(soup, uniform(0.5)).code == ErrorCode::invalid_argument);
    }
}

TEST_CASE("shared vertices give what a soup gives", "[engine][indexed][threads]") {
    check_against_soup<float>();
    check_against_soup<double>();
    check_against_soup<std::int32_t>();
    check_against_soup<std::int64_t>();
}

TEST_CASE("shared vertices are found by indices of any type and stride, and at any stride and address",
          "[engine][indexed][views]") {
    const Mesh<float> mesh = tangle<float>(300, 2000, 7);
    std::vector<std::uint64_t> records(mesh.indices.size() / 3 * 4, ~std::uint64_t{0});  // a number that is none after three
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
        records[i + i / 3] = mesh.indices[i];
    }
    MeshView wide = mesh.view();
    wide.index_type = Number::u64;
    wide.indices = records.data();
    wide.index_stride = 4 * sizeof(std::uint64_t);
    CHECK(outcome_of(wide) == outcome_of(mesh.view()));
    const std::vector<std::byte> vertices = shapes::records(mesh.xyz, 3, 33);
    wide.vertices = vertices.data() + 1;
    wide.vertex_stride = 33;
    CHECK(outcome_of(wide) == outcome_of(mesh.view()));
}

// The box of all vertices is that of the mesh where triangles have a vertex on each of its faces.
TEST_CASE("a vertex that no triangle has may be anything, and moves no face of the box", "[engine][indexed][threads]") {
    const Context context{.threads = GENERATE(1, 4)};
    const Mesh<double> mesh = tangle<double>(300, context.threads == 1 ? 2000 : 20000, 15);
    const auto expected = outcome_of(mesh.view(), uniform(3), context);
    const Box box = std::get<3>(expected);
    Mesh<double> strays = mesh;
    for (const double anything : {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, 1e300}) {
        strays.xyz.insert(strays.xyz.end(), 3, anything);
    }
    REQUIRE(IndexedSource::pays_for(strays.view()));
    CHECK(outcome_of(strays.view(), uniform(3), context) == expected);
    unsigned combination = 0;
    for (std::size_t face = 0; face < 6; ++face) {
        for (const double beyond_mm : {0.0, 0.5, 7.0}) {  // 0: on the face
            for (const bool first : {true, false}) {
                if (!tried(combination++)) {
                    continue;
                }
                Mesh<double> with_stray = mesh;
                std::array<double, 3> stray = {mesh.xyz[0], mesh.xyz[1], mesh.xyz[2]};
                stray[face % 3] = face < 3 ? box.min_mm[face] - beyond_mm : box.max_mm[face - 3] + beyond_mm;
                with_stray.xyz.insert(first ? with_stray.xyz.begin() : with_stray.xyz.end(), stray.begin(), stray.end());
                for (std::uint32_t& index : with_stray.indices) {
                    index += first ? 1 : 0;
                }
                INFO("face " << face << ", " << beyond_mm << " mm beyond it, first " << first);
                CHECK(outcome_of(with_stray.view(), uniform(3), context) == expected);
            }
        }
    }
}

TEST_CASE("what is wrong with an indexed mesh is named by its first triangle", "[engine][indexed][errors]") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    struct Case {
        std::uint32_t index;
        std::array<double, 3> vertex;  ///< number 300, the last
        const char* message;
    };
    for (const auto& [index, vertex, message] : {
             Case{301, {1, 2, 3}, "triangle 12345 has an index beyond the last vertex"},
             Case{4000000000, {1, 2, 3}, "triangle 12345 has an index beyond the last vertex"},
             Case{300, {1, nan, 2}, "triangle 12345, vertex 1, y is not finite"},
             Case{300, {1, 2, -2e9}, "triangle 12345, vertex 1, z is beyond 1e9 mm"},
         }) {
        Mesh<double> mesh = tangle<double>(300, 20000, 11);
        mesh.xyz.insert(mesh.xyz.end(), vertex.begin(), vertex.end());
        mesh.indices[3 * 12345 + 1] = mesh.indices[3 * 17000 + 1] = index;
        const Error error = failure_of(mesh.view(), uniform(3));
        CHECK(error.message == message);
        CHECK(error.code == (index == 300 ? ErrorCode::bad_coordinate : ErrorCode::invalid_argument));
    }
}

/// A rotation about an axis at random, scaled and moved.
Transform drawn_transform(std::mt19937& random) {
    std::uniform_real_distribution<double> any(-1, 1);
    Transform turned = Transform::from_normal(any(random), any(random), any(random) + 1.5);
    for (const std::size_t entry : {3U, 7U, 11U}) {
        turned.m[entry] = 100 * any(random);
    }
    return turned * Transform::scale(1 + 0.9 * any(random));
}

/// The mesh as a host of floats moves it: a matrix of floats times each vertex.
std::vector<float> moved_in_floats(const std::vector<float>& soup, const Transform& transform) {
    float m[12];
    std::copy(transform.m.begin(), transform.m.end(), m);
    std::vector<float> moved;
    for (std::size_t v = 0; v < soup.size(); v += 3) {
        for (int row = 0; row < 12; row += 4) {
            float sum = m[row] * soup[v];
            const float y = m[row + 1] * soup[v + 1];
            const float z = m[row + 2] * soup[v + 2];
            sum = sum + y;
            sum = sum + z;
            sum = sum + m[row + 3];
            moved.push_back(sum);
        }
    }
    return moved;
}

TEST_CASE("a transform in the mesh's floats gives the bytes of a mesh moved in floats", "[engine][transform][threads]") {
    std::mt19937 random(5);
    const shapes::Soup doubles = shapes::octasphere({3, 4, 5}, 20, 4);  // are moved in double by either arithmetic
    const std::vector<float> soup = shapes::floats(doubles);
    std::vector<std::uint32_t> indices(soup.size() / 3);
    std::iota(indices.begin(), indices.end(), 0U);
    const MeshView views[] = {view_of(soup), MeshView::indexed(std::span<const float>(soup), indices)};
    int differing = 0;
    for (int round = 0; round < 24; ++round) {
        SliceOptions options = uniform(0.37, round % 3 == 0 ? 1e-6 : round % 3 == 1 ? 0 : 0x1p-15);
        const Transform transform = drawn_transform(random);
        const std::vector<float> moved = moved_in_floats(soup, transform);
        const SliceResult expected = sliced(view_of(moved), options);
        options.frame.transform = transform;
        options.frame.as_mesh_numbers = true;
        const SliceResult result = sliced(views[round % 2], options, {.threads = 1 + round % 3});
        CHECK(result.hash() == expected.hash());
        CHECK(result.info.box == expected.info.box);
        CHECK(result.info.options == options);
        const std::uint64_t of_doubles = sliced(doubles, options).hash();
        options.frame.as_mesh_numbers = false;
        CHECK(sliced(doubles, options).hash() == of_doubles);
        differing += sliced(view_of(soup), options).hash() != expected.hash() ? 1 : 0;
    }
    CHECK(differing > 12);  // at a unit of 2^-15 mm double may well give the same
}

TEST_CASE("parts and audits compute a transform as slicing does", "[engine][transform][parts]") {
    std::mt19937 random(11);
    const std::vector<float> soup = shapes::floats(shapes::octasphere({3, 4, 5}, 20, 4));
    for (int round = 0; round < 8; ++round) {
        SliceOptions options{.layer_height_mm = 0.4, .frame = {.as_mesh_numbers = true}};
        const Transform placed = drawn_transform(random);
        const std::vector<Part> parts = {{.mesh = view_of(soup), .placement = placed}};
        const SliceResult result = sliced(parts, options);
        const std::vector<float> moved = moved_in_floats(soup, placed);
        CHECK(result.hash() == sliced(view_of(moved), uniform(0.4)).hash());
        options.frame.transform = placed;
        const auto certificate = value_of(audits::volume_of(sliced(view_of(soup), options), view_of(soup)));
        CHECK(certificate.verdict == VolumeVerdict::holds);
    }
}

}  // namespace
