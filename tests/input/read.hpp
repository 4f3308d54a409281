// Reading with the checks that every answer of the reader must pass.
#pragma once

#include <algorithm>
#include <array>
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

/// For the files of all tests of the readers: a file of the same name replaces the one before it.
inline const TempFolder dir;

/// Calls look(answer) with what reading a file gives: read and mapped, by 1 and 3 threads.
template <class Look>
void read_every_way(const std::filesystem::path& path, const Look& look) {
    for (const bool map : {false, true}) {
        for (const int threads : {1, 3}) {
            look(read_mesh(path, {.map_file = map}, {.threads = threads}));
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
    return value_of(read_mesh(path));
}

using Texts = std::vector<std::string>;

/// Warnings after the name of the file with which each begins.
inline Texts warnings_of(const std::filesystem::path& path) {
    Texts warnings = same_every_way(path, [](const MeshFile& mesh) { return mesh.warnings; });
    for (std::string& warning : warnings) {
        REQUIRE(warning.find(path.string() + ": ") == 0);
        warning.erase(0, path.string().size() + 2);
    }
    return warnings;
}

/// The hash of a file's slices.
inline std::uint64_t hash_of(const std::filesystem::path& path) {
    return sliced(read_one(path), uniform(0.7)).hash();
}

/// A corner of a triangle, of soup or indices, of floats or doubles; in the file's unit.
inline std::array<double, 3> corner_of(const MeshView& view, std::size_t triangle, std::size_t corner) {
    const bool soup = view.indices == nullptr;
    const std::uint64_t vertex = soup ? triangle : view.vertex_of(triangle, corner);
    REQUIRE((soup || vertex < view.vertex_count));
    const std::size_t bytes = 3 * size_of(view.vertex_type);
    const std::byte* const at = view.vertex_at(vertex) + (soup ? corner * bytes : 0);
    if (std::array<double, 3> doubles{}; view.vertex_type == Number::f64) {
        std::memcpy(doubles.data(), at, bytes);
        return doubles;
    }
    std::array<float, 3> floats{};
    std::memcpy(floats.data(), at, bytes);
    return {floats[0], floats[1], floats[2]};
}

/// Nine coordinates a triangle.
template <class Value = double>
std::vector<std::array<Value, 9>> triangles_of(const MeshFile& mesh) {
    const MeshView view = mesh.view();
    std::vector<std::array<Value, 9>> triangles(view.triangle_count);
    for (std::size_t i = 0; i < 3 * triangles.size(); ++i) {
        const std::array<double, 3> corner = corner_of(view, i / 3, i % 3);
        std::transform(corner.begin(), corner.end(), triangles[i / 3].begin() + 3 * (i % 3),
                       [](double coordinate) { return static_cast<Value>(coordinate); });
    }
    return triangles;
}

/// The same of a file.
template <class Value = double>
std::vector<std::array<Value, 9>> read_triangles(const std::filesystem::path& path) {
    return same_every_way(path, [](const MeshFile& mesh) { return triangles_of<Value>(mesh); });
}

/// The facets of a file that must be readable.
inline std::vector<Facet> read_facets(const std::filesystem::path& path) {
    return same_every_way(path, [&path](const MeshFile& mesh) {
        CHECK(mesh.file_bytes == std::filesystem::file_size(path));
        return triangles_of<float>(mesh);
    });
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

/// A file must be refused with an error that says so.
inline Error refuses(const std::filesystem::path& path, const std::string& says, const std::string& says_too = "") {
    CAPTURE(says, says_too);
    const Error error = read_error(path);
    CHECK_THAT(error.message, Catch::Contains(says) && Catch::Contains(says_too));
    return error;
}

/// The message of a file that must be refused because reading it takes more than `limit` bytes.
inline std::string message_beyond(std::uint64_t limit, const std::filesystem::path& path) {
    const Error error = error_of(read_mesh(path, {.memory_limit_bytes = limit}));
    CHECK(error.code == ErrorCode::out_of_memory);
    return error.message;
}

/// A file of only the first bytes of `whole`, [first, end) of them in turn, must be refused: as malformed, or as empty where
/// `may_be_empty`. Each is read in one of four ways.
inline void refuses_cuts(const std::string& name, const std::string& whole, std::size_t first, std::size_t end,
                         bool may_be_empty = false) {
    for (std::size_t length = first; length < end; ++length) {
        INFO(length);
        const Error error = error_of(read_mesh(dir.write(name, whole.substr(0, length)), {.map_file = length % 2 == 1},
                                               {.threads = length % 4 == 3 ? 3 : 1}));
        CHECK((error.code == ErrorCode::malformed_mesh || (may_be_empty && error.code == ErrorCode::empty_mesh)));
        CHECK(error.byte_offset <= static_cast<std::int64_t>(length));
    }
}

/// A polygon of 30,000 random corners of three, whose first is `first`: it crosses itself too often to be cut.
inline std::string entangled_corners(std::uint32_t first) {
    std::string text;
    for (std::uint32_t i = 0, random = 1; i < 30'000; ++i) {
        random = random * 1'664'525 + 1'013'904'223;
        text += " " + std::to_string((random >> 16) % 3 + first);
    }
    return text;
}

/// A replacement that makes a good file malformed, and what the error must say of it.
struct Malformed {
    std::string what;
    std::string by;
    std::string says;
    std::string says_too{};
};

inline void refuses_each(const std::string& name, const std::string& good, const std::vector<Malformed>& cases) {
    for (const Malformed& one : cases) {
        CAPTURE(one.what, one.by);
        REQUIRE(good.find(one.what) != std::string::npos);
        const auto path = dir.write(name, replaced(good, one.what, one.by));
        CHECK(refuses(path, one.says, one.says_too).code == ErrorCode::malformed_mesh);
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

// --- Corners in mm

/// Three corners in mm.
using Corners = std::array<std::array<double, 3>, 3>;

inline std::vector<Corners> corners_of(const MeshFile& mesh) {
    const MeshView view = mesh.view();
    std::vector<Corners> triangles(view.triangle_count);
    for (std::size_t i = 0; i < 3 * triangles.size(); ++i) {
        std::array<double, 3>& corner = triangles[i / 3][i % 3] = corner_of(view, i / 3, i % 3);
        for (double& coordinate : corner) {
            coordinate *= mesh.mm_per_unit;
        }
    }
    return triangles;
}

/// A file that must be readable, and the same read and mapped, by 1 and 3 threads.
inline MeshFile read_indexed(const std::filesystem::path& path) {
    same_every_way(path, [](const MeshFile& mesh) {
        REQUIRE(mesh.view().indices != nullptr);
        return std::pair(corners_of(mesh), mesh.warnings);
    });
    return read_one(path);
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
