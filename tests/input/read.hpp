// Reading with the checks that every answer of the reader must pass.
#pragma once

#include <algorithm>
#include <cstring>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/io/mesh_file.hpp"
#include "mesh_files.hpp"

namespace lamella::input_test {

/// For the files of all tests of the readers: a file of the same name replaces the one before it.
inline const TempFolder dir;

using Texts = std::vector<std::string>;

/// Calls look(answer) with what reading a file gives: read and mapped, by 1 and 3 threads.
template <class Look>
void read_every_way(const std::filesystem::path& path, const Look& look) {
    for (const bool map : {false, true}) {
        for (const int threads : {1, 3}) {
            look(read_mesh(path, {.map_file = map}, {.threads = threads}));
        }
    }
}

/// A file that must be readable.
inline MeshFile read_one(const std::filesystem::path& path) {
    return value_of(read_mesh(path));
}

/// The triangles of soup or of indices, of floats or doubles, in mm.
inline Triangles triangles_of(const MeshFile& mesh) {
    const MeshView view = mesh.view();
    const bool soup = view.indices == nullptr;
    const std::size_t bytes = size_of(view.vertex_type);
    Triangles triangles(view.triangle_count);
    for (std::size_t i = 0; i < 9 * triangles.size(); ++i) {
        const std::uint64_t vertex = soup ? i / 9 : view.vertex_of(i / 9, i % 9 / 3);
        if (!soup && vertex >= view.vertex_count) {
            FAIL("triangle " << i / 9 << " has a vertex beyond the last");
        }
        const std::byte* const at = view.vertex_at(vertex) + bytes * (soup ? i % 9 : i % 3);
        double& coordinate = triangles[i / 9][i % 9];
        if (view.vertex_type == Number::f64) {
            std::memcpy(&coordinate, at, bytes);
        } else {
            float value = 0;
            std::memcpy(&value, at, bytes);
            coordinate = value;
        }
        coordinate *= mesh.mm_per_unit;
    }
    return triangles;
}

/// A readable file's triangles and warnings, the latter without the name of the file with which each begins.
struct Contents {
    Triangles triangles;
    Texts warnings;
    MeshFile mesh;
};

/// The same however the file is read.
inline Contents read(const std::filesystem::path& path) {
    Contents first;
    read_every_way(path, [&](Result<MeshFile> mesh) {
        INFO((mesh ? "" : mesh.error().message));
        REQUIRE(mesh.ok());
        CHECK(mesh->file_bytes == std::filesystem::file_size(path));
        Contents found{triangles_of(*mesh), mesh->warnings, std::move(*mesh)};
        if (first.triangles.empty()) {
            first = std::move(found);
        } else {
            CHECK((found.triangles == first.triangles));
            CHECK(found.warnings == first.warnings);
        }
    });
    for (std::string& warning : first.warnings) {
        REQUIRE(warning.find(path.string() + ": ") == 0);
        warning.erase(0, path.string().size() + 2);
    }
    return first;
}

inline Triangles read_triangles(const std::filesystem::path& path) {
    return read(path).triangles;
}

/// A file whose values at vertices are their coordinates again.
inline void check_scalars(const std::filesystem::path& path, const std::string& name) {
    const MeshFile mesh = value_of(read_mesh(path, {.scalars = true}));
    CHECK(mesh.warnings.empty());
    REQUIRE(mesh.scalars.size() == 1);
    CHECK(mesh.scalars[0].name == name);
    REQUIRE(mesh.scalars[0].components == 3);
    const std::span<const double> values = mesh.scalars[0].values.span();
    REQUIRE(values.size() == 3 * mesh.vertex_count);
    const Triangles triangles = triangles_of(mesh);
    for (std::size_t i = 0; i < 9 * triangles.size(); ++i) {
        REQUIRE(values[3 * mesh.view().vertex_of(i / 9, i % 9 / 3) + i % 3] == triangles[i / 9][i % 9]);
    }
}

inline Texts warnings_of(const std::filesystem::path& path) {
    return read(path).warnings;
}

/// Where a message says "line L, byte B: ", B is the error's, and L the line of that byte: LF, CR and CRLF end lines.
inline void check_place(const Error& error, const std::filesystem::path& path) {
    std::smatch place;
    if (!std::regex_search(error.message, place, std::regex(": (?:line (\\d+), )?byte (\\d+): "))) {
        return;
    }
    CHECK(std::to_string(error.byte_offset) == place[2]);
    if (place[1].matched) {
        const std::string before = ::bytes_of(path).substr(0, static_cast<std::size_t>(error.byte_offset));
        const std::string lines = replaced(replaced(before, "\r\n", "\n"), "\r", "\n");
        CHECK(std::to_string(1 + std::count(lines.begin(), lines.end(), '\n')) == place[1]);
    }
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
    CHECK(first.message.size() < 400 + path.string().size());
    CHECK(first.message.find(path.string()) == 0);
    check_place(first, path);
    return first;
}

/// The message holds the texts, which " ... " parts, in this order.
inline void check_says(const std::string& message, const std::string& says) {
    CAPTURE(message);
    std::size_t found = 0;
    for (std::size_t at = 0; at < says.size();) {
        const std::size_t end = std::min(says.find(" ... ", at), says.size());
        const std::string part = says.substr(at, end - at);
        CAPTURE(part);
        found = message.find(part, found);
        REQUIRE(found != std::string::npos);
        at = end + 5;
    }
}

/// A file must be refused with an error that says so.
inline Error refuses(const std::filesystem::path& path, const std::string& says,
                     ErrorCode code = ErrorCode::malformed_mesh) {
    const Error error = read_error(path);
    CHECK(error.code == code);
    check_says(error.message, says);
    return error;
}

}  // namespace lamella::input_test
