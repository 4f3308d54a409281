// The options of a call from C, as those of C++.
#pragma once

#include <cstddef>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/lamella.h"
#include "lamella/mesh.hpp"
#include "lamella/region.hpp"
#include "lamella/slice.hpp"

namespace lamella::c {

/// Holds what the C++ options point to: neither copied nor moved once it is filled in. Its lists keep their memory.
class CallOptions {
public:
    CallOptions() = default;
    CallOptions(const CallOptions&) = delete;
    CallOptions& operator=(const CallOptions&) = delete;

    /// From what the program gave; null: the defaults. invalid_argument where a struct has no size or a choice no meaning.
    Status read(const lamella_options* given);
    Status read_control(const lamella_control* given);
    Status read_rules(const lamella_region_rules* given);

    SliceOptions options;

private:
    Status read_plan(const lamella_options& given);

    lamella_control control_{};
};

/// `in_mm`: what brings the mesh's coordinates to mm.
Status read_mesh(const lamella_mesh* given, MeshView& view, double& in_mm);

/// For a list that is NULL though it has a length.
Error missing(const char* what);

}  // namespace lamella::c
