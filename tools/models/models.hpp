// Sample meshes of any size for demonstrations, tests and benchmarks. Every mesh is closed, oriented outwards
// (counter-clockwise as seen from outside), and its neighbouring triangles share bit-identical vertices. The same recipe
// gives the same bytes on every platform: nothing but + - * / and the square root in double, and integer hashes, makes them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "lamella/control.hpp"
#include "lamella/error.hpp"

namespace lamella::models {

enum class Shape : std::uint8_t {
    sphere,  ///< rings stacked in z; an ellipsoid when the width is not the height
    torus,   ///< tilted, so that its contours are born, split, merge and die
    gyroid,  ///< a thick gyroid sheet within a ball
    bone,    ///< a femur with cortex, medullary cavity and trabeculae: about 100 contours per plane from a million triangles
             ///< on
    prism,   ///< facets as tall as the part, each crossed by every plane
};

/// By Shape.
inline constexpr std::array<std::string_view, 5> shape_names{"sphere", "torus", "gyroid", "bone", "prism"};

std::optional<Shape> shape_from_name(std::string_view name) noexcept;

enum class Order : std::uint8_t {
    z,       ///< ascending by the lowest vertex
    random,  ///< a permutation of that, by seed
};

inline constexpr std::uint64_t fewest_triangles = 100;
inline constexpr std::uint64_t most_triangles = 100'000'000;

struct Recipe {
    Shape shape = Shape::bone;
    std::uint64_t triangles = 1'000'000;  ///< met exactly where even: the triangles of a closed mesh are even in number
    double height_mm = 150;
    std::optional<double> width_mm{};  ///< along x; y follows. Default: the shape's own proportions
    /// Crossings wanted at `layer_height_mm`, met within 5 % by triangles that are flatter or steeper than the default: from
    /// about a fifth of what the shape would have by itself to once (prism) or one and a half times (bone) that.
    std::optional<std::uint64_t> segments{};
    double layer_height_mm = 0.032;  ///< read only with `segments`
    Order order = Order::z;
    std::uint64_t seed = 1;  ///< turns or varies the shape, and draws the random order
};

/// Writes the mesh as a binary STL file, aside and renamed when complete, and returns the number of triangles.
///
/// Order::z streams with memory O(cross-section); Order::random holds 36 bytes a triangle. Errors: invalid_argument (a
/// number out of range, or segments that this shape cannot give), unwritable_file, out_of_memory, cancelled. `stop` is read
/// while the file is being written, of which nothing then stays.
Result<std::uint64_t> write_stl(const Recipe& recipe, const std::filesystem::path& path, const StopCheck& stop = {});

/// The same mesh in memory, nine floats a triangle. Empty where write_stl would give invalid_argument.
std::vector<float> make_soup(const Recipe& recipe);

}  // namespace lamella::models
