// The calls of lamella.h that look at results, make structs and names, and put contours together.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "c/call.hpp"
#include "c/handles.hpp"
#include "c/sized.hpp"
#include "lamella/assemble.hpp"
#include "lamella/islands.hpp"
#include "lamella/region.hpp"
#include "lamella/version.hpp"

namespace lamella::c {

namespace {

/// By status; index: its number.
constexpr const char* status_names[] = {
    "ok",         "invalid_argument", "unreadable_file", "malformed_mesh", "empty_mesh",      "bad_coordinate",
    "bad_planes", "result_too_large", "out_of_memory",   "cancelled",      "unwritable_file",
};

/// OK is 0, and what can go wrong follows in the order of ErrorCode.
std::int32_t status_of(ErrorCode code) noexcept {
    return static_cast<std::int32_t>(code) + 1;
}
static_assert(LAMELLA_INVALID_ARGUMENT == static_cast<int>(ErrorCode::invalid_argument) + 1);
static_assert(LAMELLA_BAD_PLANES == static_cast<int>(ErrorCode::bad_planes) + 1);
static_assert(LAMELLA_UNWRITABLE_FILE == static_cast<int>(ErrorCode::unwritable_file) + 1);

lamella_view view_of(const SliceResult& result) noexcept {
    lamella_view view{};
    view.unit_mm = result.unit_mm;
    view.layers = as_c<lamella_layer>(result.layers.data());
    view.layer_count = result.layers.size();
    view.contours = as_c<lamella_contour>(result.contours.data());
    view.contour_count = result.contours.size();
    view.points = as_c<lamella_point>(result.points.data());
    view.point_count = result.points.size();
    view.closed_gaps = as_c<lamella_closed_gap>(result.closed_gaps.data());
    view.closed_gap_count = result.closed_gaps.size();
    view.layer_of = result.layer_of.data();
    view.layer_of_count = result.layer_of.size();
    copy_summary(result.summary, view);
    view.origins = result.origins.empty() ? nullptr : as_c<lamella_point_origin>(result.origins.data());
    return view;
}

/// A result of one layer, at height 0.
Status give_layer(Result<LayerContours> given, double unit_mm, const Memory* memory, lamella_result** result) {
    return fill_result(result, [&](SliceResult& filled) -> Status {
        if (!given) {
            return given.error();
        }
        filled = SliceResult(memory);
        filled.contours = std::move(given->contours);
        filled.points = std::move(given->points);
        filled.unit_mm = unit_mm;
        filled.layers.resize_discarding(1);
        filled.layers[0] = Layer{};
        filled.layers[0].contour_count = filled.contours.size();
        for (const Contour& contour : filled.contours) {
            filled.layers[0].segments += contour.segments;
            filled.summary.holes += contour.role == Role::hole ? 1 : 0;
            filled.summary.flat_contours += contour.role == Role::flat ? 1 : 0;
            filled.summary.open_contours += contour.role == Role::open ? 1 : 0;
        }
        filled.summary.segments = filled.layers[0].segments;
        return {};
    });
}

}  // namespace

std::int32_t report(const Status& status, lamella_error* error) noexcept {
    lamella_error c = defaults<lamella_error>();
    if (!status) {
        const Error& what = status.error();
        c.status = status_of(what.code);
        c.triangle = what.triangle;
        c.plane = what.plane;
        c.byte_offset = what.byte_offset;
        std::snprintf(c.message, sizeof c.message, "%s", what.message.c_str());
    }
    write_sized(c, error);
    return c.status;
}

}  // namespace lamella::c

using lamella::Contour;
using lamella::Control;
using lamella::default_unit_mm;
using lamella::Point;
using lamella::Status;
using lamella::c::as_c;
using lamella::c::as_cpp;
using lamella::c::called;
using lamella::c::CallOptions;
using lamella::c::give_layer;
using lamella::c::missing;
using lamella::c::status_names;
using lamella::c::view_of;
using lamella::c::write_sized;

void lamella_result_view(const lamella_result* result, lamella_view* view) {
    write_sized(result == nullptr ? lamella_view{} : view_of(result->result), view);
}

double lamella_result_area_mm2(const lamella_result* result, uint64_t layer) {
    return result == nullptr || layer >= result->result.layers.size()
               ? 0
               : result->result.area_mm2(result->result.layers[layer]);
}

uint64_t lamella_result_hash(const lamella_result* result) {
    return result == nullptr ? 0 : lamella::hash_result(result->result);
}

void lamella_result_free(lamella_result* result) {
    delete result;
}

double lamella_contour_area_mm2(const lamella_contour* contour, double unit_mm) {
    if (contour == nullptr) {
        return 0;
    }
    lamella::SliceResult units;
    units.unit_mm = unit_mm;
    return units.area_mm2(*as_cpp(contour));
}

int32_t lamella_next_island(const lamella_contour* contours, uint64_t contour_count, uint64_t* at, lamella_island* island) {
    if (contours == nullptr || at == nullptr || island == nullptr || *at >= contour_count) {
        return 0;
    }
    const std::span<const Contour> rest(as_cpp(contours) + *at, contour_count - *at);
    const lamella::Islands islands = lamella::islands_of(rest);
    if (islands.begin() == islands.end()) {
        *at = contour_count;
        return 0;
    }
    const lamella::Island found = *islands.begin();
    *island = {as_c<lamella_contour>(found.outer), as_c<lamella_contour>(found.holes.data()), found.holes.size()};
    *at += static_cast<std::uint64_t>(found.holes.data() + found.holes.size() - rest.data());
    return 1;
}

lamella_workspace* lamella_workspace_create(void) {
    return new (std::nothrow) lamella_workspace;
}

uint64_t lamella_workspace_bytes(const lamella_workspace* workspace) {
    return workspace == nullptr ? 0 : workspace->workspace.bytes();
}

void lamella_workspace_trim(lamella_workspace* workspace) {
    if (workspace != nullptr) {
        workspace->workspace.trim();
    }
}

void lamella_workspace_reset(lamella_workspace* workspace) {
    if (workspace != nullptr) {
        workspace->workspace.reset();
    }
}

void lamella_workspace_free(lamella_workspace* workspace) {
    delete workspace;
}

int32_t lamella_region_of(const lamella_path* contours, size_t count, const lamella_region_rules* rules, double unit_mm,
                          const lamella_control* control, lamella_result** result, lamella_error* error) {
    return called(error, [&]() -> Status {
        CallOptions call;
        if (Status status = call.read_control(control); !status) {
            return status;
        }
        if (Status status = call.read_rules(rules); !status) {
            return status;
        }
        if (contours == nullptr && count != 0) {
            return missing("contours");
        }
        std::vector<std::span<const Point>> paths;
        for (std::size_t i = 0; i < count; ++i) {
            paths.emplace_back(as_cpp(contours[i].points), contours[i].count);
        }
        const double unit = unit_mm == 0 ? default_unit_mm : unit_mm;
        const Control& host = call.options.control;
        return give_layer(lamella::region_of(paths, call.options.region, unit, host), unit, host.memory, result);
    });
}

int32_t lamella_assemble(const lamella_segment* segments, size_t count, const lamella_control* control,
                         lamella_result** result, lamella_error* error) {
    return called(error, [&]() -> Status {
        CallOptions call;
        if (Status status = call.read_control(control); !status) {
            return status;
        }
        if (segments == nullptr && count != 0) {
            return missing("segments");
        }
        const Control& host = call.options.control;
        return give_layer(lamella::assemble({as_cpp(segments), count}, host), default_unit_mm, host.memory, result);
    });
}

const char* lamella_version(void) {
    return lamella::version;
}

const char* lamella_status_name(int32_t status) {
    const bool known = status >= 0 && static_cast<std::size_t>(status) < std::size(status_names);
    return known ? status_names[status] : "unknown";
}

// NOLINTBEGIN(bugprone-macro-parentheses): a type
#define LAMELLA_INIT_SIZED(T)                  \
    void T##_init_sized(T* out, size_t size) { \
        lamella::c::init_sized(out, size);     \
    }
// NOLINTEND(bugprone-macro-parentheses)
LAMELLA_INIT_SIZED(lamella_error)
LAMELLA_INIT_SIZED(lamella_control)
LAMELLA_INIT_SIZED(lamella_mesh)
LAMELLA_INIT_SIZED(lamella_region_rules)
LAMELLA_INIT_SIZED(lamella_options)
LAMELLA_INIT_SIZED(lamella_view)
LAMELLA_INIT_SIZED(lamella_totals)
LAMELLA_INIT_SIZED(lamella_output_bounds)
LAMELLA_INIT_SIZED(lamella_host_output)
#undef LAMELLA_INIT_SIZED
