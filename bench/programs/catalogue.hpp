// Which meshes are sliced, at which planes, and what is known of the answer.
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

/// Counts of the paper authors' own program at grid 0.004 mm and layers of 0.032 mm, with the first plane 0.008 mm
/// above the lowest point.
struct KnownAnswer {
    std::uint64_t planes, segments, contours, open;
};

/// Which benchmarks measure a case.
struct Measured {
    bool partition = false;   ///< bands and parts alone
    bool cold = false;        ///< end to end with fresh memory too
    bool from_file = false;   ///< end to end from a file in the page cache too
    bool single_use = false;  ///< the above only at the thread count in `threads`
    int threads = 0;
};

struct Case {
    std::string name;
    std::function<Result<Mesh>()> mesh;
    std::string mesh_name;  ///< equal for cases of the same mesh, which are neighbours in the catalogue
    std::function<LayerPlan(const Mesh&)> plan;
    Measured measured;
    std::uint64_t triangles = 0;  ///< stated number, checked within 1 %; 0: not stated
    std::uint64_t segments = 0;   ///< stated number, checked within 5 %; 0: not stated
    std::optional<KnownAnswer> known{};
};

std::vector<Case> make_catalogue(const Options& options);

}  // namespace lamella::bench
