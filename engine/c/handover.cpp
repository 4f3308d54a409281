// The calls of lamella.h that hand layers over or write into the program's arrays.
#include <algorithm>
#include <iterator>
#include <string>
#include <variant>

#include "c/call.hpp"
#include "c/handles.hpp"
#include "c/sized.hpp"
#include "lamella/host_output.hpp"
#include "lamella/sink.hpp"

namespace lamella::c {

namespace {

lamella_totals totals_of(const SliceTotals& totals) noexcept {
    lamella_totals c{};
    c.unit_mm = totals.unit_mm;
    c.layers = totals.layers;
    c.contours = totals.contours;
    c.points = totals.points;
    c.closed_gaps = totals.closed_gaps;
    copy_summary(totals.summary, c);
    return c;
}

/// The totals that the program wants filled in, and where the layers of its heights go.
class TotalsPlace {
public:
    explicit TotalsPlace(lamella_totals* out) : out_(out) {}

    Status read(const SliceOptions& options) {
        if (Status status = read_sized(out_, "lamella_totals", place_); !status) {
            return status;
        }
        const auto* const heights = std::get_if<ExplicitPlanes>(&options.plan.spacing);
        if (place_.layer_of != nullptr && heights != nullptr && place_.layer_of_capacity < heights->heights_mm.size()) {
            return Error{ErrorCode::invalid_argument, "layer_of has room for " + std::to_string(place_.layer_of_capacity) +
                                                          " layers, but there are " +
                                                          std::to_string(heights->heights_mm.size()) + " heights"};
        }
        return {};
    }

    Status fill(const Result<SliceTotals>& given) const {
        if (!given) {
            return given.error();
        }
        lamella_totals c = totals_of(*given);
        c.layer_of = place_.layer_of;
        c.layer_of_capacity = place_.layer_of_capacity;
        if (c.layer_of != nullptr) {
            std::copy(given->layer_of.begin(), given->layer_of.end(), c.layer_of);
        }
        write_sized(c, out_);
        return {};
    }

private:
    lamella_totals* out_;
    lamella_totals place_{};
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
        c.origins = view.origins.empty() ? nullptr : as_c<lamella_point_origin>(view.origins.data());
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

Status read_output(const lamella_host_output* given, HostOutput& output) {
    lamella_host_output c;
    if (Status status = read_sized(given, "lamella_host_output", c); !status) {
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
    output.origins = as_cpp(c.origins);
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

/// `mesh` is a MeshView or a PreparedMesh.
template <class Mesh>
Status hand_over(const lamella_sink* sink, const Mesh& mesh, Call& call, lamella_totals* totals) {
    if (Status status = check_sink(sink); !status) {
        return status;
    }
    TotalsPlace place(totals);
    if (Status status = place.read(call.options()); !status) {
        return status;
    }
    SinkOfC taking(*sink);
    const auto order = sink->order == LAMELLA_SINK_ANY ? SinkOrder::any : SinkOrder::ascending;
    return place.fill(slice_to(LayerSink::to(taking, order), mesh, call.options(), call.workspace()));
}

template <class Mesh>
Status write_into(const lamella_host_output* output, const Mesh& mesh, Call& call, lamella_totals* totals) {
    HostOutput host;
    if (Status status = read_output(output, host); !status) {
        return status;
    }
    TotalsPlace place(totals);
    if (Status status = place.read(call.options()); !status) {
        return status;
    }
    return place.fill(slice_into(host, mesh, call.options(), call.workspace()));
}

template <class Mesh>
Status bound(const Mesh& mesh, Call& call, lamella_output_bounds* bounds) {
    const Result<OutputBounds> found = bound_output(mesh, call.options(), call.workspace());
    if (!found) {
        return found.error();
    }
    write_sized(bounds_of(*found), bounds);
    return {};
}

}  // namespace
}  // namespace lamella::c

using lamella::c::bound;
using lamella::c::called_with;
using lamella::c::hand_over;
using lamella::c::write_into;

int32_t lamella_slice_to(const lamella_sink* sink, const lamella_mesh* mesh, const lamella_options* options,
                         lamella_workspace* workspace, lamella_totals* totals, lamella_error* error) {
    return called_with(mesh, options, workspace, error,
                       [&](const auto& view, auto& call) { return hand_over(sink, view, call, totals); });
}

int32_t lamella_slice_prepared_to(const lamella_sink* sink, const lamella_prepared* prepared, const lamella_options* options,
                                  lamella_workspace* workspace, lamella_totals* totals, lamella_error* error) {
    return called_with(prepared, options, workspace, error,
                       [&](const auto& made, auto& call) { return hand_over(sink, made, call, totals); });
}

int32_t lamella_bound_output(const lamella_mesh* mesh, const lamella_options* options, lamella_workspace* workspace,
                             lamella_output_bounds* bounds, lamella_error* error) {
    return called_with(mesh, options, workspace, error,
                       [&](const auto& view, auto& call) { return bound(view, call, bounds); });
}

int32_t lamella_bound_prepared_output(const lamella_prepared* prepared, const lamella_options* options,
                                      lamella_workspace* workspace, lamella_output_bounds* bounds, lamella_error* error) {
    return called_with(prepared, options, workspace, error,
                       [&](const auto& made, auto& call) { return bound(made, call, bounds); });
}

int32_t lamella_slice_into(const lamella_host_output* output, const lamella_mesh* mesh, const lamella_options* options,
                           lamella_workspace* workspace, lamella_totals* totals, lamella_error* error) {
    return called_with(mesh, options, workspace, error,
                       [&](const auto& view, auto& call) { return write_into(output, view, call, totals); });
}

int32_t lamella_slice_prepared_into(const lamella_host_output* output, const lamella_prepared* prepared,
                                    const lamella_options* options, lamella_workspace* workspace, lamella_totals* totals,
                                    lamella_error* error) {
    return called_with(prepared, options, workspace, error,
                       [&](const auto& made, auto& call) { return write_into(output, made, call, totals); });
}
