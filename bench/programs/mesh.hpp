// A mesh as the benchmarks hold it: a packed triangle soup, and the file that it came from.
#pragma once

#include <cstdint>
#include <filesystem>

#include "lamella/array.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "models/models.hpp"

namespace lamella::bench {

struct Mesh {
    Array<float> soup;           ///< nine a triangle
    std::filesystem::path file;  ///< empty where there is none
    double low_mm = 0;           ///< z of the lowest vertex
    double high_mm = 0;          ///< z of the highest
    double rise_mm = 0;          ///< the heights of all triangles, summed: divided by the layer height, the crossings

    std::uint64_t triangles() const noexcept { return soup.size() / 9; }
    std::uint64_t bytes() const noexcept { return soup.size() * sizeof(float); }
    MeshView view() const noexcept { return MeshView::soup(soup.span()); }

    /// Fills in the heights from `soup`.
    void measure() noexcept;
};

Result<Mesh> load_mesh(const std::filesystem::path& file);

/// Where the recipe's mesh is kept in `cache`; made there unless it is there already.
Result<std::filesystem::path> cached_mesh(const models::Recipe& recipe, const std::filesystem::path& cache);

/// `count` closed columns of `sides` sides, on a square lattice of 1 mm: 2 * sides facets each that are as tall as the part
/// and sides - 2 at either end.
Mesh make_columns(std::uint32_t count, std::uint32_t sides, double height_mm);

}  // namespace lamella::bench
