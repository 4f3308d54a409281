// Which meshes are cut, where, and what is known of the answer.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lamella/planes.hpp"
#include "mesh.hpp"
#include "options.hpp"

namespace lamella::bench {

/// Counts at grid 0.004 mm and layers of 0.032 mm, the first plane 0.008 mm above the lowest point: the counts of the paper
/// authors' own program.
struct KnownAnswer {
    std::uint64_t planes, segments, contours, open;
};

/// What a case is measured by.
struct Measured {
    bool stages = false;      ///< every stage, and the contour forms, by themselves
    bool assembled = false;   ///< end to end in the assembled form too
    bool cold = false;        ///< end to end with fresh memory too
    bool from_file = false;   ///< end to end from a file in the page cache too
    bool single_use = false;  ///< of those: only at the thread count in `threads`
    int threads = 0;
};

struct Case {
    std::string name;
    std::function<Result<Mesh>()> mesh;
    std::string mesh_name;  ///< equal for cases of the same mesh, which are neighbours in the catalogue
    std::function<LayerPlan(const Mesh&)> plan;
    Measured measured;
    std::uint64_t triangles = 0;  ///< as stated, met within 1 %; 0: nothing stated
    std::uint64_t segments = 0;   ///< as stated, met within 5 %; 0: nothing stated
    std::optional<KnownAnswer> known{};
};

std::vector<Case> make_catalogue(const Options& options);

}  // namespace lamella::bench
