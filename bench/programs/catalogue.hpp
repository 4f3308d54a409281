// Which meshes are sliced, at which planes, and what is known of the answer.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lamella/array.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "models/models.hpp"
#include "slicing/tuning.hpp"

namespace lamella::bench {

struct Options {
    std::filesystem::path cache = "bench-models";  ///< generated meshes are kept here from run to run
    std::filesystem::path shared;                  ///< folder of real meshes, if there are any
    bool quick = false;                            ///< a hundredth of all sizes, to test the benchmarks
    /// See add_partition(): GB/s of a core, GB/s and cores of a socket, us to wake a thread, GB/s of fresh pages.
    std::array<double, 5> modelled{20, 400, 64, 20, 10};
};

/// 1, 2, 4, ... and all cores.
std::vector<int> thread_counts();

/// A packed triangle soup and the file it came from.
struct Mesh {
    Array<float> soup;           ///< nine numbers a triangle
    std::filesystem::path file;  ///< empty if there is no file

    std::uint64_t triangles() const noexcept { return soup.size() / 9; }
    std::uint64_t bytes() const noexcept { return soup.size() * sizeof(float); }
    MeshView view() const noexcept { return MeshView::soup(soup.span()); }
};

/// Throws std::runtime_error.
Mesh load_mesh(const std::filesystem::path& file);

/// A file NAME.stl of the recipe's mesh. Makes it unless it exists.
std::filesystem::path cached_mesh(const Options& options, const std::string& name, const models::Recipe& recipe);

/// Counts of the paper authors' own program at grid 0.004 mm and layers of 0.032 mm, with the first plane 0.008 mm
/// above the lowest point.
struct KnownAnswer {
    std::uint64_t planes, segments, contours, open;
};

inline constexpr double layer_mm = 0.032;

/// Where a case is cut.
struct Plan {
    SliceOptions options{};
    Tuning tuning{};
};

struct Case {
    std::string name;
    std::string mesh_name;  ///< equal for cases of the same mesh, which are neighbours in the catalogue
    std::function<Mesh()> mesh;
    std::function<Plan(const Mesh&)> plan = [](const Mesh& /*mesh*/) { return Plan{{.layer_height_mm = layer_mm}}; };
    std::uint64_t triangles = 0;  ///< stated number, checked within 1 %; 0: not stated
    std::uint64_t segments = 0;   ///< stated number, checked within 5 %; 0: not stated
    bool from_file = false;       ///< end to end from a file too
    bool hosts = false;           ///< the calls that hosts make too
    bool partition = false;       ///< the speed-up that more threads than there are would allow too
    bool regions = false;         ///< with regions too
    int only_threads = 0;         ///< 0: every thread count
    std::optional<KnownAnswer> known{};
};

std::vector<Case> make_catalogue(const Options& options);

inline std::uint64_t result_bytes(const SliceInfo& info) {
    return info.layers * sizeof(Layer) + info.contours * sizeof(Contour) + info.points * sizeof(Point);
}

}  // namespace lamella::bench
