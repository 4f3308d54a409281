// The calls of lamella.h that cut a mesh.
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "c/call.hpp"
#include "c/call_options.hpp"
#include "c/handles.hpp"
#include "c/sized.hpp"
#include "lamella/host_output.hpp"
#include "lamella/parts.hpp"
#include "lamella/prepare.hpp"
#include "lamella/sink.hpp"
#include "lamella/slice.hpp"

namespace lamella::c {

namespace {

/// Mesh, options and workspace of one call.
class Call {
public:
    explicit Call(lamella_workspace* workspace) : kept_(workspace) {
        if (kept_ == nullptr) {
            own_ = std::make_unique<lamella_workspace>();
            kept_ = own_.get();
        }
    }

    Status read(const lamella_options* given) { return kept_->options.read(given); }
    Status read(const lamella_mesh* given_mesh, const lamella_options* given) {
        if (Status status = read(given); !status) {
            return status;
        }
        double in_mm = 1;
        if (Status status = read_mesh(given_mesh, mesh, in_mm); !status) {
            return status;
        }
        if (in_mm != 1) {
            options().transform = options().transform * Transform::scale(in_mm);
        }
        return {};
    }

    SliceOptions& options() noexcept { return kept_->options.options; }
    Workspace& workspace() noexcept { return kept_->workspace; }

    MeshView mesh;

private:
    std::unique_ptr<lamella_workspace> own_;
    lamella_workspace* kept_;
};

/// Hands layers to a function of C.
class SinkOfC {
public:
    explicit SinkOfC(const lamella_sink& sink) : sink_(sink) {}

    void operator()(const LayerView& view) const noexcept {
        lamella_layer_view c{};
        c.struct_size = sizeof c;
        c.index = view.index;
        c.unit_mm = view.unit_mm;
        c.layer = as_c<lamella_layer>(&view.layer);
        c.contours = as_c<lamella_contour>(view.contours.data());
        c.contour_count = view.contours.size();
        c.points = as_c<lamella_point>(view.points.data());
        c.point_count = view.points.size();
        c.closed_gaps = as_c<lamella_closed_gap>(view.closed_gaps.data());
        c.closed_gap_count = view.closed_gaps.size();
        sink_.take(sink_.context, &c);
    }

private:
    const lamella_sink& sink_;
};

Status check_sink(const lamella_sink* sink) {
    if (sink == nullptr || sink->take == nullptr) {
        return Error{ErrorCode::invalid_argument, "the sink has no function that takes layers"};
    }
    if (sink->order != LAMELLA_SINK_ANY && sink->order != LAMELLA_SINK_ASCENDING) {
        return Error{ErrorCode::invalid_argument,
                     "the sink's order is " + std::to_string(sink->order) + ", but the choices are 0 to 1"};
    }
    return {};
}

/// `slice_to(sink)` is the call of C++.
template <class SliceTo>
Status hand_over(const lamella_sink* sink, lamella_totals* totals, const SliceTo& slice_to) {
    if (Status status = check_sink(sink); !status) {
        return status;
    }
    SinkOfC taking(*sink);
    const auto order = sink->order == LAMELLA_SINK_ANY ? SinkOrder::any : SinkOrder::ascending;
    const Result<SliceTotals> given = slice_to(LayerSink::to(taking, order));
    if (!given) {
        return given.error();
    }
    write_sized(totals_of(*given), totals);
    return {};
}

Status read_output(const lamella_host_output* given, HostOutput& output) {
    lamella_host_output c;
    if (Status status = read_sized(given, default_host_output(), "lamella_host_output", c); !status) {
        return status;
    }
    switch (c.point_type) {
        case LAMELLA_F32:
            output.type = PointType::f32;
            break;
        case LAMELLA_F64:
            output.type = PointType::f64;
            break;
        case LAMELLA_I32:
            output.type = PointType::i32;
            break;
        case LAMELLA_I64:
            output.type = PointType::i64;
            break;
        default:
            return Error{ErrorCode::invalid_argument,
                         "point_type is " + std::to_string(c.point_type) + ", but the choices are 0 to 3"};
    }
    output.points = c.points;
    output.point_capacity = c.point_capacity;
    output.stride = c.point_stride;
    output.scale = c.scale;
    output.contours = as_cpp(c.contours);
    output.contour_capacity = c.contour_capacity;
    output.layers = as_cpp(c.layers);
    output.layer_capacity = c.layer_capacity;
    output.closed_gaps = as_cpp(c.closed_gaps);
    output.closed_gap_capacity = c.closed_gap_capacity;
    return {};
}

lamella_output_bounds bounds_of(const OutputBounds& bounds) noexcept {
    lamella_output_bounds c{};
    c.are_certain = bounds.are_certain ? 1 : 0;
    c.layers = bounds.layers;
    c.contours = bounds.contours;
    c.points = bounds.points;
    c.segments = bounds.segments;
    c.unit_mm = bounds.unit_mm;
    return c;
}

/// `transforms`: twelve numbers a mesh, or null.
Status read_parts(const lamella_mesh* const* meshes, const double* transforms, std::size_t count, std::vector<Part>& parts) {
    if (meshes == nullptr && count != 0) {
        return Error{ErrorCode::invalid_argument, "meshes is NULL, but its count is not 0"};
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

}  // namespace
}  // namespace lamella::c

using lamella::Error;
using lamella::ErrorCode;
using lamella::HostOutput;
using lamella::LayerSink;
using lamella::OutputBounds;
using lamella::Part;
using lamella::PartRegions;
using lamella::PreparedMesh;
using lamella::PrepareOptions;
using lamella::Result;
using lamella::SliceResult;
using lamella::SliceTotals;
using lamella::Status;
using lamella::c::bounds_of;
using lamella::c::Call;
using lamella::c::called;
using lamella::c::CallOptions;
using lamella::c::fill_result;
using lamella::c::give_result;
using lamella::c::hand_over;
using lamella::c::read_output;
using lamella::c::read_parts;
using lamella::c::totals_of;
using lamella::c::write_sized;

int32_t lamella_slice(const lamella_mesh* mesh, const lamella_options* options, lamella_workspace* workspace,
                      lamella_result** result, lamella_error* error) {
    return called(error, [&]() -> Status {
        Call call(workspace);
        if (Status status = call.read(mesh, options); !status) {
            return status;
        }
        return fill_result(result, [&](SliceResult& filled) {
            return lamella::slice(call.mesh, call.options(), call.workspace(), filled);
        });
    });
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
    return called(error, [&]() -> Status {
        if (prepared == nullptr) {
            return Error{ErrorCode::invalid_argument, "the prepared mesh is NULL"};
        }
        Call call(workspace);
        if (Status status = call.read(options); !status) {
            return status;
        }
        return fill_result(result, [&](SliceResult& filled) {
            return lamella::slice(prepared->mesh, call.options(), call.workspace(), filled);
        });
    });
}

uint64_t lamella_prepared_bytes(const lamella_prepared* prepared) {
    return prepared == nullptr ? 0 : prepared->mesh.bytes();
}

void lamella_prepared_free(lamella_prepared* prepared) {
    delete prepared;
}

int32_t lamella_slice_to(const lamella_sink* sink, const lamella_mesh* mesh, const lamella_options* options,
                         lamella_workspace* workspace, lamella_totals* totals, lamella_error* error) {
    return called(error, [&]() -> Status {
        Call call(workspace);
        if (Status status = call.read(mesh, options); !status) {
            return status;
        }
        return hand_over(sink, totals, [&](const LayerSink& to) {
            return lamella::slice_to(to, call.mesh, call.options(), call.workspace());
        });
    });
}

int32_t lamella_slice_prepared_to(const lamella_sink* sink, const lamella_prepared* prepared, const lamella_options* options,
                                  lamella_workspace* workspace, lamella_totals* totals, lamella_error* error) {
    return called(error, [&]() -> Status {
        if (prepared == nullptr) {
            return Error{ErrorCode::invalid_argument, "the prepared mesh is NULL"};
        }
        Call call(workspace);
        if (Status status = call.read(options); !status) {
            return status;
        }
        return hand_over(sink, totals, [&](const LayerSink& to) {
            return lamella::slice_to(to, prepared->mesh, call.options(), call.workspace());
        });
    });
}

int32_t lamella_bound_output(const lamella_mesh* mesh, const lamella_options* options, lamella_workspace* workspace,
                             lamella_output_bounds* bounds, lamella_error* error) {
    return called(error, [&]() -> Status {
        Call call(workspace);
        if (Status status = call.read(mesh, options); !status) {
            return status;
        }
        const Result<OutputBounds> bound = lamella::bound_output(call.mesh, call.options(), call.workspace());
        if (!bound) {
            return bound.error();
        }
        write_sized(bounds_of(*bound), bounds);
        return {};
    });
}

int32_t lamella_slice_into(const lamella_host_output* output, const lamella_mesh* mesh, const lamella_options* options,
                           lamella_workspace* workspace, lamella_totals* totals, lamella_error* error) {
    return called(error, [&]() -> Status {
        Call call(workspace);
        if (Status status = call.read(mesh, options); !status) {
            return status;
        }
        HostOutput host;
        if (Status status = read_output(output, host); !status) {
            return status;
        }
        const Result<SliceTotals> given = lamella::slice_into(host, call.mesh, call.options(), call.workspace());
        if (!given) {
            return given.error();
        }
        write_sized(totals_of(*given), totals);
        return {};
    });
}
