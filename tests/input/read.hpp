// Reading with the checks that every answer of the reader must pass.
#pragma once

#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "files.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella::input_test {

/// Calls look(answer) with what reading a file gives: read and mapped, by 1 and 3 threads.
template <class Look>
void read_every_way(const std::filesystem::path& path, const Look& look) {
    for (const bool map : {false, true}) {
        for (const int threads : {1, 3}) {
            ReadOptions options;
            options.control.threads = threads;
            options.map_file = map;
            look(read_mesh(path, options));
        }
    }
}

/// What look(mesh) makes of a file that must be readable: the same, however it is read.
template <class Look>
auto same_every_way(const std::filesystem::path& path, const Look& look) {
    std::optional<decltype(look(std::declval<const MeshFile&>()))> first;
    read_every_way(path, [&](const Result<MeshFile>& mesh) {
        INFO((mesh ? "" : mesh.error().message));
        REQUIRE(mesh.ok());
        auto found = look(mesh.value());
        if (!first) {
            first = found;
        }
        CHECK((found == *first));
    });
    return *std::move(first);
}

inline std::vector<Facet> facets_of(const MeshFile& mesh) {
    const MeshView view = mesh.view();
    std::vector<Facet> facets(view.triangle_count);
    for (std::size_t t = 0; t < facets.size(); ++t) {
        std::memcpy(facets[t].data(), view.vertices + t * view.stride, sizeof(Facet));
    }
    return facets;
}

/// The facets of a file that must be readable.
inline std::vector<Facet> read_facets(const std::filesystem::path& path) {
    return same_every_way(path, [&path](const MeshFile& mesh) {
        CHECK(mesh.file_bytes == std::filesystem::file_size(path));
        return facets_of(mesh);
    });
}

/// One of those four ways: for loops over so many files that each is read once.
inline Result<MeshFile> read_in_turn(const std::filesystem::path& path, std::size_t turn) {
    ReadOptions options;
    options.control.threads = turn % 4 == 3 ? 3 : 1;
    options.map_file = turn % 2 == 1;
    return read_mesh(path, options);
}

/// The error of a file that must be refused: the same read and mapped, one line that names the file.
inline Error read_error(const std::filesystem::path& path) {
    Error first;
    read_every_way(path, [&first](const Result<MeshFile>& mesh) {
        REQUIRE_FALSE(mesh.ok());
        if (first.message.empty()) {
            first = mesh.error();
        }
        CHECK(mesh.error().message == first.message);
        CHECK(mesh.error().code == first.code);
        CHECK(mesh.error().byte_offset == first.byte_offset);
    });
    INFO(first.message);
    CHECK(first.message.find('\n') == std::string::npos);
    CHECK(first.message.find(path.string()) == 0);
    return first;
}

/// "NAME ROLE FIRST COUNT; ..."
inline std::string parts_of(const MeshFile& file) {
    std::string text;
    for (const MeshPart& part : file.parts) {
        text += part.name + " " + std::string(name_of(part.role)) + " " + std::to_string(part.first_triangle) + " " +
                std::to_string(part.triangle_count) + "; ";
    }
    return text;
}

}  // namespace lamella::input_test
