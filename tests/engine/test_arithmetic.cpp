// Transforms in the mesh's number type: as a host computes them.
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/parts.hpp"

using lamella::Arithmetic;
using lamella::MeshView;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::Transform;

namespace {

MeshView view_of_floats(const std::vector<float>& soup) {
    return MeshView::soup(std::span<const float>(soup));
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

/// The mesh as vertices and indices, in the same order.
struct IndexedFloats {
    std::vector<float> xyz;
    std::vector<std::uint32_t> indices;
    explicit IndexedFloats(const std::vector<float>& soup) : xyz(soup) {
        for (std::uint32_t v = 0; v < soup.size() / 3; ++v) {
            indices.push_back(v);
        }
    }
    MeshView view() const { return MeshView::indexed(std::span<const float>(xyz), indices); }
};

}  // namespace

TEST_CASE("a transform in the mesh's floats gives the bytes of a mesh moved in floats", "[engine][transform][threads]") {
    std::mt19937 random(5);
    const std::vector<float> soup = shapes::floats(shapes::octasphere({3, 4, 5}, 20, 4));
    const IndexedFloats indexed(soup);
    int differing = 0;
    for (int round = 0; round < 24; ++round) {
        SliceOptions options = uniform(0.37, round % 3 == 0 ? 1e-6 : round % 3 == 1 ? 0 : 0x1p-15);
        const Transform transform = drawn_transform(random);
        const std::vector<float> moved = moved_in_floats(soup, transform);
        const SliceResult expected = sliced(view_of_floats(moved), options);
        options.transform = transform;
        options.transform.arithmetic = Arithmetic::as_mesh;
        options.control.threads = 1 + round % 3;
        const SliceResult result = sliced(round % 2 == 0 ? view_of_floats(soup) : indexed.view(), options);
        CHECK(hash_result(result) == hash_result(expected));
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(result.summary.min_mm[axis] == expected.summary.min_mm[axis]);
            CHECK(result.summary.max_mm[axis] == expected.summary.max_mm[axis]);
        }
        CHECK(result.frame.arithmetic == Arithmetic::as_mesh);
        options.transform.arithmetic = Arithmetic::f64;
        differing += hash_result(sliced(view_of_floats(soup), options)) != hash_result(expected) ? 1 : 0;
    }
    CHECK(differing > 12);  // at a unit of 2^-15 mm double may well give the same
}

TEST_CASE("a top face on a plane in the host's floats is never missed", "[engine][transform]") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> size(0.5, 60);
    int missed_in_floats = 0;
    int missed_in_doubles = 0;
    lamella::Workspace workspace;
    SliceResult result;
    for (int round = 0; round < 4000; ++round) {
        const std::vector<float> soup = shapes::floats(shapes::box({0, 0, 0}, {size(random), size(random), size(random)}));
        Transform transform = Transform::scale(0.2 + size(random) / 40);
        transform.m[3] = size(random);
        transform.m[11] = size(random);
        const std::vector<float> moved = moved_in_floats(soup, transform);
        float top = moved[2];
        for (std::size_t v = 2; v < moved.size(); v += 3) {
            top = std::max(top, moved[v]);
        }
        // The plane passes below vertices of its height, so it must meet the box whose top face lies on it.
        SliceOptions options;
        options.control.threads = 1;
        options.plan.spacing = lamella::ExplicitPlanes{{static_cast<double>(top)}};
        options.transform = transform;
        for (const Arithmetic arithmetic : {Arithmetic::as_mesh, Arithmetic::f64}) {
            options.transform.arithmetic = arithmetic;
            REQUIRE(slice(view_of_floats(soup), options, workspace, result).ok());
            (arithmetic == Arithmetic::as_mesh ? missed_in_floats : missed_in_doubles) += result.contours.empty() ? 1 : 0;
        }
    }
    CHECK(missed_in_floats == 0);
    CHECK(missed_in_doubles > 200);
}

TEST_CASE("a mesh of doubles is moved in double by either arithmetic", "[engine][transform]") {
    std::mt19937 random(9);
    const shapes::Soup soup = shapes::octasphere({3, 4, 5}, 20, 3);
    for (int round = 0; round < 8; ++round) {
        SliceOptions options = uniform(0.5);
        options.transform = drawn_transform(random);
        const std::uint64_t expected = hash_result(sliced(soup, options));
        options.transform.arithmetic = Arithmetic::as_mesh;
        CHECK(hash_result(sliced(soup, options)) == expected);
    }
}

TEST_CASE("products of transforms keep the mesh's arithmetic of either", "[engine][transform]") {
    Transform half = Transform::scale(0.5);
    half.arithmetic = Arithmetic::as_mesh;
    const Transform twice = Transform::scale(2);
    Transform none;
    none.arithmetic = Arithmetic::as_mesh;
    CHECK((half * twice).arithmetic == Arithmetic::as_mesh);
    CHECK((twice * half).arithmetic == Arithmetic::as_mesh);
    CHECK((twice * none).arithmetic == Arithmetic::as_mesh);
    CHECK((twice * none).m == twice.m);
    CHECK((twice * twice).arithmetic == Arithmetic::f64);
}

TEST_CASE("parts and audits compute a transform as slicing does", "[engine][transform][parts]") {
    std::mt19937 random(11);
    const std::vector<float> soup = shapes::floats(shapes::octasphere({3, 4, 5}, 20, 4));
    for (int round = 0; round < 8; ++round) {
        SliceOptions options = uniform(0.4);
        const Transform placed = drawn_transform(random);
        options.transform.arithmetic = Arithmetic::as_mesh;
        const std::vector<lamella::Part> parts = {{.mesh = view_of_floats(soup), .transform = placed}};
        const auto result = value_of(slice_parts(parts, options));
        const std::vector<float> moved = moved_in_floats(soup, placed);
        CHECK(hash_result(result) == hash_result(sliced(view_of_floats(moved), uniform(0.4))));
        options.transform = placed;
        options.transform.arithmetic = Arithmetic::as_mesh;
        const auto certificate = value_of(certify_volume(view_of_floats(soup), sliced(view_of_floats(soup), options)));
        CHECK(certificate.verdict == lamella::VolumeVerdict::holds);
    }
}

TEST_CASE("what floats cannot hold after a transform names its triangle", "[engine][transform][errors]") {
    const std::vector<float> soup = shapes::floats(shapes::box({0, 0, 0}, {1, 1, 1}));
    SliceOptions options;
    options.transform = Transform::scale(1e39);
    options.transform.arithmetic = Arithmetic::as_mesh;
    const lamella::Error error = failure_of(view_of_floats(soup), options);
    CHECK(error.code == lamella::ErrorCode::bad_coordinate);
    CHECK(error.triangle == 0);
}
