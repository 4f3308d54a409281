// Building files in memory, and access to the mesh that they are written from.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <type_traits>

#include "lamella/mesh/weld.hpp"

namespace lamella::bench {

/// The contents of a file, appended piece by piece.
class Text {
public:
    Text& operator<<(std::string_view piece) {
        all_ += piece;
        return *this;
    }
    /// Appends the shortest decimals that read back as the same number.
    template <class Number>
    requires std::is_arithmetic_v<Number> Text& operator<<(Number number) {
        std::array<char, 32> digits;
        all_.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr);
        return *this;
    }
    /// Appends the bytes of the number.
    template <class Number>
    Text& bytes(Number number, std::endian order = std::endian::little) {
        std::array<char, sizeof(Number)> raw;
        std::memcpy(raw.data(), &number, sizeof number);
        if (order != std::endian::native) {
            std::reverse(raw.begin(), raw.end());
        }
        all_.append(raw.data(), raw.size());
        return *this;
    }
    const std::string& all() const noexcept { return all_; }

private:
    std::string all_;
};

inline std::array<float, 3> vertex_of(const WeldedMesh& mesh, std::uint64_t vertex) {
    std::array<float, 3> xyz;
    std::memcpy(xyz.data(), mesh.coordinates.data() + vertex * sizeof xyz, sizeof xyz);
    return xyz;
}

template <class Write>
void for_vertices(const WeldedMesh& mesh, const Write& write) {
    for (std::uint64_t vertex = 0; vertex < mesh.vertex_count; ++vertex) {
        write(vertex_of(mesh, vertex));
    }
}

/// Calls write(corners) for each triangle; the numbers of vertices count from `first`.
template <class Write>
void for_triangles(const WeldedMesh& mesh, const Write& write, std::uint32_t first = 0) {
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        write(std::array{mesh.indices[i] + first, mesh.indices[i + 1] + first, mesh.indices[i + 2] + first});
    }
}

inline std::uint64_t triangles_of(const WeldedMesh& mesh) {
    return mesh.indices.size() / 3;
}

inline std::uint64_t save(const std::string& contents, const std::filesystem::path& file) {
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    out.write(contents.data(), static_cast<std::streamsize>(contents.size())).flush();
    return out ? contents.size() : 0;
}

}  // namespace lamella::bench
