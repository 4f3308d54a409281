// The options of a call from C, as those of C++.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>

#include "c/handles.hpp"
#include "c/sized.hpp"

namespace lamella::c {

namespace {

/// The value of a C++ enumeration whose values are 0 to `last`.
template <class Enum>
Status read_choice(std::int32_t given, Enum last, const char* name, Enum& choice) {
    if (given < 0 || given > static_cast<std::int32_t>(last)) {
        return Error{ErrorCode::invalid_argument, std::string(name) + " is " + std::to_string(given) +
                                                      ", but the choices are 0 to " +
                                                      std::to_string(static_cast<std::int32_t>(last))};
    }
    choice = static_cast<Enum>(given);
    return {};
}

/// The first of several that went wrong.
Status first_failure(std::initializer_list<Status> of) {
    const auto failed = std::find_if(of.begin(), of.end(), [](const Status& status) { return !status; });
    return failed == of.end() ? Status{} : *failed;
}

}  // namespace

Error missing(const char* what) {
    return {ErrorCode::invalid_argument, std::string(what) + " is NULL, but its count is not 0"};
}

Status read_mesh(const lamella_mesh* given, MeshView& view, double& in_mm) {
    if (given == nullptr) {
        return Error{ErrorCode::invalid_argument, "the mesh is NULL"};
    }
    lamella_mesh c;
    if (Status status = read_sized(given, "lamella_mesh", c); !status) {
        return status;
    }
    CoordinateType type{};
    IndexType index_type{};
    if (Status status = first_failure({read_choice(c.coordinate_type, CoordinateType::i64, "coordinate_type", type),
                                       read_choice(c.index_type, IndexType::u64, "index_type", index_type)});
        !status) {
        return status;
    }
    if (c.vertices == nullptr && c.triangle_count != 0) {
        return missing("vertices");
    }
    if (!(c.coordinate_mm > 0) || !std::isfinite(c.coordinate_mm)) {
        return Error{ErrorCode::invalid_argument, "coordinate_mm must be finite and above 0"};
    }
    in_mm = c.coordinate_mm;
    const bool narrow = type == CoordinateType::f32 || type == CoordinateType::i32;
    const std::size_t row = (c.indices == nullptr ? 9U : 3U) * (narrow ? 4U : 8U);
    const std::size_t stride = c.vertex_stride == 0 ? row : c.vertex_stride;
    const auto* const vertices = static_cast<const std::byte*>(c.vertices);
    if (c.indices == nullptr) {
        view = MeshView::strided_soup(vertices, c.triangle_count, stride, type);
        return {};
    }
    const std::size_t indices = index_type == IndexType::u32 ? 3 * sizeof(std::uint32_t) : 3 * sizeof(std::uint64_t);
    view = MeshView::indexed(vertices, c.vertex_count, stride, type, static_cast<const std::byte*>(c.indices),
                             c.triangle_count, c.index_stride == 0 ? indices : c.index_stride, index_type);
    return {};
}

/// The functions of C go by way of the struct, since those of C++ promise not to throw, which C cannot say.
Status CallOptions::read_control(const lamella_control* given) {
    if (Status status = read_sized(given, "lamella_control", control_); !status) {
        return status;
    }
    Control& control = options.control;
    control = {};
    control.threads = control_.threads;
    control.memory = as_cpp(control_.memory);
    if (control_.executor != nullptr) {
        control.executor = {[](void* self, int workers, void (*body)(void*) noexcept, void* argument) noexcept {
                                const auto& c = *static_cast<const lamella_control*>(self);
                                c.executor(c.executor_context, workers, body, argument);
                            },
                            &control_, control_.executor_threads};
    }
    if (control_.stop != nullptr) {
        control.stop = {[](void* self) noexcept {
                            const auto& c = *static_cast<const lamella_control*>(self);
                            return c.stop(c.stop_context) != 0;
                        },
                        &control_};
    }
    if (control_.progress != nullptr) {
        control.progress = {[](void* self, double fraction) noexcept {
                                const auto& c = *static_cast<const lamella_control*>(self);
                                c.progress(c.progress_context, fraction);
                            },
                            &control_};
    }
    return {};
}

Status CallOptions::read_rules(const lamella_region_rules* given) {
    lamella_region_rules c;
    if (Status status = read_sized(given, "lamella_region_rules", c); !status) {
        return status;
    }
    RegionRules& rules = options.region;
    if (Status status = read_choice(c.fill_rule, FillRule::outermost, "fill_rule", rules.fill_rule); !status) {
        return status;
    }
    if (c.fill_from == nullptr && c.fill_from_count != 0) {
        return missing("fill_from");
    }
    rules.fill_from.clear();
    for (std::size_t i = 0; i < c.fill_from_count; ++i) {
        FillFrom& from = rules.fill_from.emplace_back();
        from.first_layer = c.fill_from[i].first_layer;
        if (Status status = read_choice(c.fill_from[i].fill_rule, FillRule::outermost, "fill_rule of fill_from", from.rule);
            !status) {
            return status;
        }
    }
    rules.largest_only = c.largest_only != 0;
    rules.drop_collinear = c.drop_collinear != 0;
    rules.close_mm = c.close_mm;
    rules.offset_mm = c.offset_mm;
    rules.miter_limit = c.miter_limit;
    rules.mark_near_mm = c.mark_near_mm;
    rules.simplify_mm = c.simplify_mm;
    return {};
}

Status CallOptions::read_plan(const lamella_options& given) {
    LayerPlan& plan = options.plan;
    if (Status status = read_choice(given.side, PlaneSide::above, "side", plan.side); !status) {
        return status;
    }
    if (given.spacing == LAMELLA_LAYERS_AT_HEIGHTS) {
        if (given.heights_mm == nullptr && given.height_count != 0) {
            return missing("heights_mm");
        }
        if (!std::holds_alternative<ExplicitPlanes>(plan.spacing)) {
            plan.spacing = ExplicitPlanes{};
        }
        std::get<ExplicitPlanes>(plan.spacing).heights_mm.assign(given.heights_mm, given.heights_mm + given.height_count);
        return {};
    }
    if (given.spacing != LAMELLA_LAYERS_UNIFORM) {
        return Error{ErrorCode::invalid_argument,
                     "spacing is " + std::to_string(given.spacing) + ", but the choices are 0 to 1"};
    }
    UniformLayers layers;
    layers.layer_height_mm = given.layer_height_mm;
    if (!std::isnan(given.first_height_mm)) {
        layers.first_height_mm = given.first_height_mm;
    }
    Status status = read_choice(given.datum, Datum::zero, "datum", layers.datum);
    plan.spacing = layers;
    return status;
}

Status CallOptions::read(const lamella_options* given) {
    lamella_options c;
    if (Status status = read_sized(given, "lamella_options", c); !status) {
        return status;
    }
    if (Status status =
            first_failure({read_plan(c), read_rules(c.region),
                           read_choice(c.arithmetic, Arithmetic::as_mesh, "arithmetic", options.transform.arithmetic),
                           read_choice(c.unit_fit, UnitFit::coarser_if_needed, "unit_fit", options.unit_fit),
                           read_choice(c.gap_sense, GapSense::any, "gap_sense", options.gap_sense)});
        !status) {
        return status;
    }
    options.allow_empty = c.allow_empty != 0;
    options.origins = c.origins != 0;
    options.unit_mm = c.unit_mm;
    std::copy(std::begin(c.transform), std::end(c.transform), options.transform.m.begin());
    options.close_gaps_mm = c.close_gaps_mm;
    options.memory_limit_bytes = c.memory_limit_bytes;
    return read_control(c.control);
}

}  // namespace lamella::c
