// Reading files of vertices and indices, with the checks that every answer must pass.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <vector>

#include <catch2/catch.hpp>

#include "lamella/io/mesh_file.hpp"
#include "read.hpp"

namespace lamella::input_test {

/// Three corners in mm.
using Corners = std::array<std::array<double, 3>, 3>;

/// Of soup or indices, of floats or doubles.
inline std::vector<Corners> corners_of(const MeshFile& mesh) {
    const MeshView view = mesh.view();
    const bool is_double = view.coordinate_type == CoordinateType::f64;
    const std::size_t bytes = is_double ? sizeof(double) : sizeof(float);
    std::vector<Corners> triangles(view.triangle_count);
    for (std::size_t i = 0; i < 3 * triangles.size(); ++i) {
        const bool soup = view.indices == nullptr;
        REQUIRE((soup || view.vertex_of(i / 3, i % 3) < view.vertex_count));
        const std::byte* at =
            view.vertices + (soup ? i / 3 * view.stride + i % 3 * 3 * bytes : view.vertex_of(i / 3, i % 3) * view.stride);
        for (double& coordinate : triangles[i / 3][i % 3]) {
            float single = 0;
            std::memcpy(is_double ? static_cast<void*>(&coordinate) : &single, at, bytes);
            coordinate = (is_double ? coordinate : static_cast<double>(single)) * mesh.mm_per_unit;
            at += bytes;
        }
    }
    return triangles;
}

/// A file that must be readable, and the same read and mapped, by 1 and 3 threads.
inline MeshFile read_indexed(const std::filesystem::path& path) {
    MeshFile first;
    read_every_way(path, [&first](Result<MeshFile> mesh) {
        INFO((mesh ? "" : mesh.error().message));
        REQUIRE(mesh.ok());
        REQUIRE(mesh->view().indices != nullptr);
        if (first.triangle_count > 0) {
            CHECK(corners_of(*mesh) == corners_of(first));
            CHECK(mesh->warnings == first.warnings);
        }
        first = std::move(mesh).value();
    });
    return first;
}

/// Six times the volume, signed: positive where triangles are seen counter-clockwise from outside.
inline double six_volumes(const std::vector<Corners>& triangles) {
    double sum = 0;
    for (const auto& [a, b, c] : triangles) {
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum;
}

/// The lowest and the highest corner of the box around the triangles.
inline std::array<std::array<double, 3>, 2> box_of(const std::vector<Corners>& triangles) {
    std::array<std::array<double, 3>, 2> box = {triangles.at(0)[0], triangles.at(0)[0]};
    for (const Corners& corners : triangles) {
        for (const auto& corner : corners) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                box[0][axis] = std::min(box[0][axis], corner[axis]);
                box[1][axis] = std::max(box[1][axis], corner[axis]);
            }
        }
    }
    return box;
}

}  // namespace lamella::input_test
