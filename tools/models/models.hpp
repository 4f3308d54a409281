// Sample meshes of any size for demonstrations, tests and benchmarks. Every mesh is closed and oriented outwards
// (counter-clockwise as seen from outside), and neighbouring triangles share bit-identical vertices. The same recipe
// gives the same bytes on every platform, because only + - * /, the square root in double and integer hashes compute
// it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/error.hpp"

namespace lamella::models {

enum class Shape : std::uint8_t {
    sphere,  ///< rings stacked in z; an ellipsoid if the width differs from the height
    torus,   ///< tilted, so that its contours are born, split, merge and die
    gyroid,  ///< a thick gyroid sheet within a ball
    bone,    ///< a femur with cortex, medullary cavity and trabeculae; about 100 contours a plane from a million triangles
             ///< upwards
    prism,   ///< facets as tall as the part, each crossed by every plane
};

/// Names of shapes, by Shape.
inline constexpr std::array<std::string_view, 5> shape_names{"sphere", "torus", "gyroid", "bone", "prism"};

enum class Order : std::uint8_t {
    z,       ///< ascending by the lowest vertex
    random,  ///< a permutation of the ascending order, by seed
};

inline constexpr std::uint64_t fewest_triangles = 100;
inline constexpr std::uint64_t most_triangles = 1'000'000'000;
inline constexpr std::uint64_t most_shuffled = 100'000'000;  ///< in Order::random, which holds them all

struct Recipe {
    Shape shape = Shape::bone;
    std::uint64_t triangles = 1'000'000;  ///< met exactly if even; a closed mesh has an even number
    double height_mm = 150;
    std::optional<double> width_mm{};  ///< along x; y is in proportion. Default: the shape's own proportions
    /// The number of crossings at `layer_height_mm`, met within 5 % by triangles that are flatter or steeper than the
    /// default. It can be from about a fifth of the shape's default number up to that number (prism) or one and a half times
    /// it (bone).
    std::optional<std::uint64_t> segments{};
    double layer_height_mm = 0.032;  ///< used only with `segments`
    Order order = Order::z;
    std::uint64_t seed = 1;  ///< turns or varies the shape, and selects the random order
};

/// Writes the mesh as a binary STL file and returns the number of triangles. The file is written under a temporary name
/// and renamed when complete.
///
/// Memory is O(cross-section) for Order::z and 36 bytes a triangle for Order::random. Errors: invalid_argument (a
/// number out of range, or a number of segments that this shape cannot have), unwritable_file, out_of_memory,
/// cancelled. `stop` is asked while the file is being written; a stopped call leaves no file.
Result<std::uint64_t> write_stl(const Recipe& recipe, const std::filesystem::path& path, const Callback<bool()>& stop = {});

/// The same mesh in memory, nine floats a triangle. Empty where write_stl would return invalid_argument.
std::vector<float> make_soup(const Recipe& recipe);

}  // namespace lamella::models
