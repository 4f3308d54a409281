// The calls of lamella.h that cut a mesh into a result.
#include <memory>
#include <utility>
#include <vector>

#include "c/call.hpp"
#include "c/handles.hpp"
#include "lamella/parts.hpp"
#include "lamella/prepare.hpp"
#include "lamella/slabs.hpp"
#include "lamella/slice.hpp"

namespace lamella::c {

namespace {

/// `transforms`: twelve numbers a mesh, or null.
Status read_parts(const lamella_mesh* const* meshes, const double* transforms, std::size_t count, std::vector<Part>& parts) {
    if (meshes == nullptr && count != 0) {
        return missing("meshes");
    }
    for (std::size_t p = 0; p < count; ++p) {
        Part& part = parts.emplace_back();
        double in_mm = 1;
        if (Status status = read_mesh(meshes[p], part.mesh, in_mm); !status) {
            return status;
        }
        if (transforms != nullptr) {
            std::copy_n(transforms + 12 * p, 12, part.transform.m.begin());
        }
        if (in_mm != 1) {
            part.transform = part.transform * Transform::scale(in_mm);
        }
    }
    return {};
}

/// Refuses what slabs know nothing of, rather than leave it undone in silence.
Status slab_options_of(const SliceOptions& given, SlabOptions& options) {
    if (given.close_gaps_mm != 0 || given.origins) {
        return Error{ErrorCode::invalid_argument, "slabs have neither gaps that are joined nor origins"};
    }
    options.plan = given.plan;
    options.unit_mm = given.unit_mm;
    options.unit_fit = given.unit_fit;
    options.allow_empty = given.allow_empty;
    options.transform = given.transform;
    options.region = given.region;
    options.memory_limit_bytes = given.memory_limit_bytes;
    options.control = given.control;
    return {};
}

/// `mesh` is a MeshView or a PreparedMesh.
template <class Mesh>
Status slice_result(const Mesh& mesh, Call& call, lamella_result** result) {
    return fill_result(result, [&](SliceResult& filled) { return slice(mesh, call.options(), call.workspace(), filled); });
}

}  // namespace
}  // namespace lamella::c

using lamella::Error;
using lamella::ErrorCode;
using lamella::Part;
using lamella::PartRegions;
using lamella::PreparedMesh;
using lamella::PrepareOptions;
using lamella::Result;
using lamella::SlabOptions;
using lamella::Slabs;
using lamella::SliceResult;
using lamella::Status;
using lamella::c::Call;
using lamella::c::called;
using lamella::c::called_with;
using lamella::c::CallOptions;
using lamella::c::give_result;
using lamella::c::read_parts;
using lamella::c::slab_options_of;
using lamella::c::slice_result;

int32_t lamella_slice(const lamella_mesh* mesh, const lamella_options* options, lamella_workspace* workspace,
                      lamella_result** result, lamella_error* error) {
    return called_with(mesh, options, workspace, error,
                       [&](const auto& view, auto& call) { return slice_result(view, call, result); });
}

int32_t lamella_slice_parts(const lamella_mesh* const* meshes, const double* transforms, size_t count,
                            const lamella_options* options, int32_t part_regions, lamella_result** result,
                            lamella_error* error) {
    return called(error, [&]() -> Status {
        CallOptions call;
        if (Status status = call.read(options); !status) {
            return status;
        }
        if (part_regions != LAMELLA_PARTS_SEPARATE && part_regions != LAMELLA_PARTS_UNITED) {
            return Error{ErrorCode::invalid_argument,
                         "part_regions is " + std::to_string(part_regions) + ", but the choices are 0 to 1"};
        }
        std::vector<Part> parts;
        if (Status status = read_parts(meshes, transforms, count, parts); !status) {
            return status;
        }
        const auto regions = part_regions == LAMELLA_PARTS_UNITED ? PartRegions::united : PartRegions::separate;
        return give_result(lamella::slice_parts(parts, call.options, regions), result);
    });
}

int32_t lamella_slice_slabs(const lamella_mesh* mesh, const lamella_options* options, lamella_result** top,
                            lamella_result** bottom, lamella_error* error) {
    return called(error, [&]() -> Status {
        Call call(nullptr);
        if (Status status = call.read(mesh, options); !status) {
            return status;
        }
        SlabOptions how;
        if (Status status = slab_options_of(call.options(), how); !status) {
            return status;
        }
        how.top = top != nullptr;
        how.bottom = bottom != nullptr;
        Result<Slabs> slabs = lamella::slice_slabs(call.mesh, how);
        if (!slabs) {
            return slabs.error();
        }
        // Both results are made before either is given.
        std::unique_ptr<lamella_result> fresh[2];
        lamella_result** const places[] = {top, bottom};
        SliceResult* const made[] = {&slabs->top, &slabs->bottom};
        for (int i = 0; i < 2; ++i) {
            if (places[i] != nullptr && *places[i] == nullptr) {
                fresh[i] = std::make_unique<lamella_result>();
            }
        }
        for (int i = 0; i < 2; ++i) {
            if (places[i] != nullptr) {
                *places[i] = fresh[i] != nullptr ? fresh[i].release() : *places[i];
                (*places[i])->result = std::move(*made[i]);
            }
        }
        return {};
    });
}

int32_t lamella_prepare(const lamella_mesh* mesh, const lamella_options* options, lamella_prepared** prepared,
                        lamella_error* error) {
    return called(error, [&]() -> Status {
        if (prepared == nullptr) {
            return Error{ErrorCode::invalid_argument, "there is nowhere to put the prepared mesh: prepared is NULL"};
        }
        Call call(nullptr);
        if (Status status = call.read(mesh, options); !status) {
            return status;
        }
        PrepareOptions how;
        how.unit_mm = call.options().unit_mm;
        how.unit_fit = call.options().unit_fit;
        how.allow_empty = call.options().allow_empty;
        how.transform = call.options().transform;
        how.control = call.options().control;
        Result<PreparedMesh> made = lamella::prepare(call.mesh, how);
        if (!made) {
            return made.error();
        }
        auto fresh = std::make_unique<lamella_prepared>(lamella_prepared{std::move(*made)});
        lamella_prepared_free(std::exchange(*prepared, fresh.release()));
        return {};
    });
}

int32_t lamella_slice_prepared(const lamella_prepared* prepared, const lamella_options* options,
                               lamella_workspace* workspace, lamella_result** result, lamella_error* error) {
    return called_with(prepared, options, workspace, error,
                       [&](const auto& made, auto& call) { return slice_result(made, call, result); });
}

uint64_t lamella_prepared_bytes(const lamella_prepared* prepared) {
    return prepared == nullptr ? 0 : prepared->mesh.bytes();
}

double lamella_prepared_unit_mm(const lamella_prepared* prepared) {
    return prepared == nullptr ? 0 : prepared->mesh.unit_mm();
}

void lamella_prepared_free(lamella_prepared* prepared) {
    delete prepared;
}
