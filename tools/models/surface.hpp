// What the generators have in common: a surface whose size is settled before any triangle is made, and the way its triangles
// leave it, sorted by height and split here and there until their number is the one asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
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

/// Takes the next triangles; false stops the making.
using Consumer = std::function<bool(std::span<const Triangle>)>;

/// Passes triangles on. Of `candidates` splittable ones, `splits` are cut in three at their centre, evenly spread: each adds
/// two triangles and touches no edge that a neighbour shares.
class Emitter {
public:
    Emitter(const Consumer& consume, std::uint64_t candidates, std::uint64_t splits);

    void add(const Triangle& triangle) { pending_.push_back(triangle); }
    void add_splittable(const Triangle& triangle);
    std::size_t pending() const noexcept { return pending_.size(); }

    /// Hands over what was added, sorted by lowest vertex. Batches must ascend. False once the consumer has had enough.
    bool flush();

private:
    const Consumer& consume_;
    std::uint64_t candidates_;
    std::uint64_t splits_;
    std::uint64_t due_;  // counts up by splits_; reaching candidates_ means a split
    bool stopped_ = false;
    std::vector<Triangle> pending_;
    std::vector<Triangle> sorted_;
    std::vector<std::uint64_t> keys_;
};

class Surface {
public:
    Surface() = default;
    Surface(const Surface&) = delete;
    Surface& operator=(const Surface&) = delete;
    virtual ~Surface() = default;

    /// Exactly as many as emit() hands over.
    virtual std::uint64_t triangles() const noexcept = 0;

    /// In ascending order of lowest vertices. False if the consumer stopped it.
    virtual bool emit(const Consumer& consume) = 0;
};

using Plan = Result<std::unique_ptr<Surface>>;

/// Sphere and prism.
Plan plan_rings(const Recipe& recipe);

/// Torus, gyroid and bone.
Plan plan_isosurface(const Recipe& recipe);

/// The error for a size that the shape cannot have; `nearest` counts crossings.
Error unreachable(const Recipe& recipe, double nearest);

}  // namespace lamella::models
