// From the objects and the build of a 3MF model to one mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/parallel.hpp"
#include "io/read/three_mf/three_mf_model.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/memory.hpp"

namespace lamella::three_mf {

/// What is wrong with a build, and where in the package.
struct BuildProblem {
    ErrorCode code = ErrorCode::malformed_mesh;
    Place place;
    std::string what;
};

/// A mesh object where the build wants it.
struct Instance {
    std::uint32_t object = 0;  ///< index
    Transform transform;
    bool mirrored = false;            ///< its triangles are reversed, so that they face outwards again
    std::uint32_t label = 0;          ///< the innermost that has a name
    PartRole role = PartRole::solid;  ///< of the outermost that is not solid

    auto key() const noexcept { return std::tuple(object, label, role); }
};

/// All solid instances of the build, by object, and `parts`: those of one object and name are one. Nested components can
/// make more instances than any machine can hold: they are refused where they and their mesh would take more than
/// `limit_bytes`. Types and roles that are no part of the solid are left out, with a warning added
/// to the model's.
std::optional<BuildProblem> list_instances(Model& model, std::uint64_t limit_bytes, const Parallel& parallel,
                                           std::vector<Instance>& instances, std::vector<MeshPart>& parts);

/// The mesh of all instances. The model's meshes are released as they are copied.
void place(Model& model, const std::vector<Instance>& instances, const Memory* memory, const Parallel& parallel,
           MeshFile& mesh);

}  // namespace lamella::three_mf
