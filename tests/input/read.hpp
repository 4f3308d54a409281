// Reading with the checks that every answer of the reader must pass.
#pragma once

#include <cstring>
#include <vector>

#include <catch2/catch.hpp>

#include "files.hpp"
#include "lamella/mesh_file.hpp"

namespace lamella::input_test {

/// The facets of a file that must be readable, the same read and mapped, by 1 and 3 threads.
inline std::vector<Facet> facets_of(const MeshFile& mesh) {
    const MeshView view = mesh.view();
    std::vector<Facet> facets(view.triangle_count);
    for (std::size_t t = 0; t < facets.size(); ++t) {
        std::memcpy(facets[t].data(), view.vertices + t * view.stride, sizeof(Facet));
    }
    return facets;
}

inline std::vector<Facet> read_facets(const std::filesystem::path& path) {
    std::vector<Facet> first;
    for (const bool map : {false, true}) {
        for (const int threads : {1, 3}) {
            ReadOptions options;
            options.threads = threads;
            options.map_file = map;
            const Result<MeshFile> mesh = read_mesh(path, options);
            INFO((mesh ? "" : mesh.error().message));
            REQUIRE(mesh.ok());
            CHECK(mesh.value().file_bytes == std::filesystem::file_size(path));
            if (first.empty()) {
                first = facets_of(mesh.value());
            }
            CHECK(facets_of(mesh.value()) == first);
        }
    }
    return first;
}

/// The error of a file that must be refused: the same read and mapped, one line that names the file.
inline Error read_error(const std::filesystem::path& path) {
    Error first;
    for (const bool map : {false, true}) {
        for (const int threads : {1, 3}) {
            ReadOptions options;
            options.threads = threads;
            options.map_file = map;
            const Result<MeshFile> mesh = read_mesh(path, options);
            REQUIRE_FALSE(mesh.ok());
            if (first.message.empty()) {
                first = mesh.error();
            }
            CHECK(mesh.error().message == first.message);
            CHECK(mesh.error().code == first.code);
            CHECK(mesh.error().byte_offset == first.byte_offset);
        }
    }
    INFO(first.message);
    CHECK(first.message.find('\n') == std::string::npos);
    CHECK(first.message.find(path.string()) == 0);
    return first;
}

}  // namespace lamella::input_test
