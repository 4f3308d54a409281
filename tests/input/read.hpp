// Reading with the checks that every answer of the reader must pass.
#pragma once

#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
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

/// A file that must be readable.
inline MeshFile read_one(const std::filesystem::path& path) {
    Result<MeshFile> mesh = read_mesh(path);
    INFO((mesh ? "" : mesh.error().message));
    REQUIRE(mesh.ok());
    return std::move(mesh).value();
}

/// Warnings after the name of the file with which each begins.
inline std::vector<std::string> warnings_of(const std::filesystem::path& path) {
    std::vector<std::string> warnings = same_every_way(path, [](const MeshFile& mesh) { return mesh.warnings; });
    for (std::string& warning : warnings) {
        REQUIRE(warning.find(path.string() + ": ") == 0);
        warning.erase(0, path.string().size() + 2);
    }
    return warnings;
}

/// The hash of a file's slices.
inline std::uint64_t hash_of(const std::filesystem::path& path) {
    return hash_result(sliced(read_one(path).view(), uniform(0.7)));
}

/// Nine coordinates a triangle, of a mesh with indices.
template <class Value = double>
std::vector<std::array<Value, 9>> triangles_of(const MeshFile& mesh) {
    const MeshView view = mesh.view();
    REQUIRE(view.indices != nullptr);
    std::vector<std::array<Value, 9>> triangles(view.triangle_count);
    for (std::size_t i = 0; i < 3 * triangles.size(); ++i) {
        const std::uint64_t vertex = view.vertex_of(i / 3, i % 3);
        REQUIRE(vertex < view.vertex_count);
        std::array<double, 3> doubles{};
        if (view.coordinate_type == CoordinateType::f64) {
            std::memcpy(doubles.data(), view.vertices + vertex * view.stride, sizeof doubles);
        } else {
            std::array<float, 3> floats{};
            std::memcpy(floats.data(), view.vertices + vertex * view.stride, sizeof floats);
            std::copy(floats.begin(), floats.end(), doubles.begin());
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            triangles[i / 3][3 * (i % 3) + axis] = static_cast<Value>(doubles[axis]);
        }
    }
    return triangles;
}

/// The same of a file.
template <class Value = double>
std::vector<std::array<Value, 9>> read_triangles(const std::filesystem::path& path) {
    return same_every_way(path, [](const MeshFile& mesh) { return triangles_of<Value>(mesh); });
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

/// The message of a file that must be refused because reading it takes more than `limit` bytes.
inline std::string message_beyond(std::uint64_t limit, const std::filesystem::path& path) {
    const Result<MeshFile> mesh = read_mesh(path, {.memory_limit_bytes = limit});
    REQUIRE_FALSE(mesh.ok());
    CHECK(mesh.error().code == ErrorCode::out_of_memory);
    return mesh.error().message;
}

/// A file of only the first bytes of `whole`, [first, end) of them in turn, must be refused: as malformed, or as empty where
/// `may_be_empty`.
inline void refuses_cuts(const TempFolder& dir, const std::string& name, const std::string& whole, std::size_t first,
                         std::size_t end, bool may_be_empty = false) {
    for (std::size_t length = first; length < end; ++length) {
        INFO(length);
        const Result<MeshFile> mesh = read_in_turn(dir.write(name, whole.substr(0, length)), length);
        REQUIRE_FALSE(mesh.ok());
        const bool empty = may_be_empty && mesh.error().code == ErrorCode::empty_mesh;
        CHECK((empty || mesh.error().code == ErrorCode::malformed_mesh));
        CHECK(mesh.error().byte_offset <= static_cast<std::int64_t>(length));
    }
}

/// A replacement that makes a good file malformed, and what the error must say of it.
struct Malformed {
    std::string what;
    std::string by;
    std::string says;
    std::string says_too{};
};

inline void refuses_each(const TempFolder& dir, const std::string& name, const std::string& good,
                         const std::vector<Malformed>& cases) {
    for (const Malformed& one : cases) {
        CAPTURE(one.what, one.by);
        REQUIRE(good.find(one.what) != std::string::npos);
        const Error error = read_error(dir.write(name, replaced(good, one.what, one.by)));
        CHECK(error.code == ErrorCode::malformed_mesh);
        CHECK_THAT(error.message, Catch::Contains(one.says) && Catch::Contains(one.says_too));
    }
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
