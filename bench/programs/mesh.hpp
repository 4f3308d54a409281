// A mesh for the benchmarks: a packed triangle soup and the file it came from.
#pragma once

#include <cstdint>
#include <filesystem>

#include "lamella/array.hpp"
#include "lamella/mesh.hpp"
#include "models/models.hpp"

namespace lamella::bench {

struct Mesh {
    Array<float> soup;           ///< nine numbers a triangle
    std::filesystem::path file;  ///< empty if there is no file
    double low_mm = 0;           ///< z of the lowest vertex
    double high_mm = 0;          ///< z of the highest vertex
    double rise_mm = 0;          ///< sum of all triangles' heights; divided by the layer height, it gives the crossings

    std::uint64_t triangles() const noexcept { return soup.size() / 9; }
    std::uint64_t bytes() const noexcept { return soup.size() * sizeof(float); }
    MeshView view() const noexcept { return MeshView::soup(soup.span()); }

    /// Computes the heights from `soup`.
    void measure() noexcept;
};

// These throw std::runtime_error.
Mesh load_mesh(const std::filesystem::path& file);

/// The file of the recipe's mesh in `cache`. Makes it unless it exists.
std::filesystem::path cached_mesh(const models::Recipe& recipe, const std::filesystem::path& cache);

/// `count` closed columns of `sides` sides on a square lattice of 1 mm. A column has 2 * sides facets over its full
/// height and sides - 2 at either end.
Mesh make_columns(std::uint32_t count, std::uint32_t sides, double height_mm);

}  // namespace lamella::bench
