// Transforms in the mesh's number type: as a host computes them.
#include <numeric>
#include <random>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"

using lamella::MeshView;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::Transform;

namespace {

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

}  // namespace

TEST_CASE("a transform in the mesh's floats gives the bytes of a mesh moved in floats", "[engine][transform][threads]") {
    std::mt19937 random(5);
    const std::vector<float> soup = shapes::floats(shapes::octasphere({3, 4, 5}, 20, 4));
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
        options.frame.as_mesh_numbers = false;
        differing += sliced(view_of(soup), options).hash() != expected.hash() ? 1 : 0;
    }
    CHECK(differing > 12);  // at a unit of 2^-15 mm double may well give the same
}

TEST_CASE("a mesh of doubles is moved in double by either arithmetic", "[engine][transform]") {
    std::mt19937 random(9);
    const shapes::Soup soup = shapes::octasphere({3, 4, 5}, 20, 3);
    for (int round = 0; round < 8; ++round) {
        SliceOptions options = uniform(0.5);
        options.frame.transform = drawn_transform(random);
        const std::uint64_t expected = sliced(soup, options).hash();
        options.frame.as_mesh_numbers = true;
        CHECK(sliced(soup, options).hash() == expected);
    }
}

TEST_CASE("parts and audits compute a transform as slicing does", "[engine][transform][parts]") {
    std::mt19937 random(11);
    const std::vector<float> soup = shapes::floats(shapes::octasphere({3, 4, 5}, 20, 4));
    for (int round = 0; round < 8; ++round) {
        SliceOptions options = uniform(0.4);
        const Transform placed = drawn_transform(random);
        options.frame.as_mesh_numbers = true;
        const std::vector<lamella::Part> parts = {{.mesh = view_of(soup), .placement = placed}};
        const SliceResult result = sliced(parts, options);
        const std::vector<float> moved = moved_in_floats(soup, placed);
        CHECK(result.hash() == sliced(view_of(moved), uniform(0.4)).hash());
        options.frame.transform = placed;
        const auto certificate = value_of(audits::volume_of(sliced(view_of(soup), options), view_of(soup)));
        CHECK(certificate.verdict == lamella::VolumeVerdict::holds);
    }
}

TEST_CASE("what floats cannot hold after a transform names its triangle", "[engine][transform][errors]") {
    const std::vector<float> soup = shapes::floats(shapes::box({0, 0, 0}, {1, 1, 1}));
    SliceOptions options;
    options.frame.transform = Transform::scale(1e39);
    options.frame.as_mesh_numbers = true;
    const lamella::Error error = failure_of(view_of(soup), options);
    CHECK(error.code == lamella::ErrorCode::bad_coordinate);
    CHECK(error.triangle == 0);
}
