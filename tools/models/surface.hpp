// Shared by the generators: a surface whose size is known before any triangle is made, and the output of its
// triangles. Output sorts triangles by height and splits some until their number is the requested one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "lamella/error.hpp"
#include "models/models.hpp"

namespace lamella::models {

struct Vertex {
    float x = 0;
    float y = 0;
    float z = 0;
};

/// Counter-clockwise as seen from outside.
struct Triangle {
    Vertex a, b, c;
};
static_assert(sizeof(Triangle) == 9 * sizeof(float), "a soup is an array of these");

/// Receives the next triangles; returns false to stop the generator.
using Consumer = std::function<bool(std::span<const Triangle>)>;

/// Passes triangles on. Of `candidates` splittable triangles, `splits`, evenly distributed, are split in three at their
/// centre. A split adds two triangles and changes no edge that a neighbour shares.
class Emitter {
public:
    Emitter(const Consumer& consume, std::uint64_t candidates, std::uint64_t splits);

    void add(const Triangle& triangle) { pending_.push_back(triangle); }
    void add_splittable(const Triangle& triangle);
    std::size_t pending() const noexcept { return pending_.size(); }

    /// Passes on the triangles added so far, sorted by lowest vertex. Batches must ascend. False once the consumer has
    /// stopped.
    bool flush();

private:
    const Consumer& consume_;
    std::uint64_t candidates_;
    std::uint64_t splits_;
    std::uint64_t due_;  // grows by splits_; reaching candidates_ means a split
    bool stopped_ = false;
    std::vector<Triangle> pending_;
    std::vector<Triangle> sorted_;
    std::vector<std::uint64_t> keys_;
};

struct Surface {
    std::uint64_t triangles = 0;  ///< that emit() passes on
    /// Emits triangles in ascending order of lowest vertices. False if the consumer stopped it.
    std::function<bool(const Consumer&)> emit;
};

using Plan = Result<Surface>;

/// The surface of a recipe, and its triangles in the recipe's order. The random order is Fisher and Yates's shuffle.
Plan plan(const Recipe& recipe);
std::vector<Triangle> collect(const Recipe& recipe, const Surface& surface);

/// Sphere and prism.
Plan plan_rings(const Recipe& recipe);

/// Torus, gyroid and bone.
Plan plan_isosurface(const Recipe& recipe);

/// The error for a size that the shape cannot have. `nearest` is the nearest possible number of crossings.
Error unreachable(const Recipe& recipe, double nearest);

}  // namespace lamella::models
