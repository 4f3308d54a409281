// The real test meshes, and their corners as plain numbers.
#pragma once

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "lamella/io/mesh_file.hpp"

inline const std::filesystem::path folder = LAMELLA_SHARED_MODELS;

/// Every mesh in the folder and its subfolders, by name.
inline std::vector<std::filesystem::path> real_meshes() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (entry.path().extension() == ".stl") {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

inline shapes::Soup soup_of(const std::filesystem::path& file) {
    const lamella::Result<lamella::MeshFile> mesh = lamella::read_mesh(file);
    REQUIRE(mesh.ok());
    const lamella::MeshView view = mesh->view();
    REQUIRE(view.vertex_type == lamella::Number::f32);
    REQUIRE(view.indices == nullptr);
    shapes::Soup soup;
    for (std::size_t t = 0; t < view.triangle_count; ++t) {
        float corners[9];
        std::memcpy(corners, view.vertex_at(t), sizeof corners);
        soup.insert(soup.end(), std::begin(corners), std::end(corners));
    }
    return soup;
}
