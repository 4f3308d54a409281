// The meshes of the golden cases: nothing but integers divided by a power of two, so that no compiler, C library or number
// type can change them. Each fits 24 bits, so that float and double hold the same mesh.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "engine/shapes.hpp"

namespace golden {

using shapes::Soup;

/// The mesh of that name, in mm.
Soup mesh(const std::string& name);

std::vector<std::string> mesh_names();

/// One mesh of triangles, quads and larger polygons in every format, by file name. Large enough to be parsed by several
/// tasks.
std::map<std::string, std::string> mesh_files();

/// Steele, Lea and Flood's generator.
class SplitMix {
public:
    explicit SplitMix(std::uint64_t seed) noexcept : state_(seed) {}
    std::uint64_t next() noexcept {
        std::uint64_t z = state_ += 0x9E3779B97F4A7C15;
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9;
        z = (z ^ z >> 27) * 0x94D049BB133111EB;
        return z ^ z >> 31;
    }
    /// From low to high, both possible.
    int between(int low, int high) noexcept {
        return low + static_cast<int>(next() % static_cast<std::uint64_t>(high - low + 1));
    }

private:
    std::uint64_t state_;
};

}  // namespace golden
