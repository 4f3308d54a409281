// The calls of lamella.h that look at results, judge meshes and results, and make structs and names.
#include <algorithm>
#include <cstring>
#include <iterator>
#include <span>
#include <utility>

#include "c/call.hpp"
#include "lamella/audit.hpp"
#include "lamella/check.hpp"
#include "lamella/version.hpp"
#include "lamella/weld.hpp"

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
static_assert(std::size(lamella_check_result{}.faults) == fault_count);

void copy_box(const Box& box, double (&least)[3], double (&most)[3]) noexcept {
    std::copy(box.min_mm.begin(), box.min_mm.end(), least);
    std::copy(box.max_mm.begin(), box.max_mm.end(), most);
}

lamella_check_result check_of(const MeshCheck& found, bool counts_only) noexcept {
    lamella_check_result c{};
    c.closed = found.closed ? 1 : 0;
    c.clean = !counts_only && found.clean() ? 1 : 0;
    c.complete = found.complete() ? 1 : 0;
    c.triangles = found.triangles;
    c.degenerate = found.degenerate;
    c.edges = found.edges;
    c.boundary_edges = found.boundary_edges;
    c.overfull_edges = found.overfull_edges;
    c.mismatched_edges = found.mismatched_edges;
    c.shells = found.shell_count;
    copy_box(found.box, c.min_mm, c.max_mm);
    c.volume_mm3 = found.volume_mm3;
    c.area_mm2 = found.area_mm2;
    c.grid_mm = found.grid_mm;
    std::transform(found.findings.begin(), found.findings.end(), c.faults, [](const FaultFinding& f) { return f.count; });
    return c;
}

lamella_audit_result audit_of(const Audit& found) noexcept {
    auto c = defaults<lamella_audit_result>();
    c.open_layers = found.open->layers;
    c.open_share = found.open->share();
    c.stitch_mm = found.open->reach_mm;
    c.stuck_layers = found.open->stuck;
    c.crossings = found.crossings->count;
    c.structure = *found.structure ? LAMELLA_OK : status_of(found.structure->error().code);
    if (found.volume) {
        c.volume = static_cast<std::int32_t>(found.volume->verdict);
        c.mesh_mm3 = found.volume->mesh_mm3;
        c.slabs_mm3 = found.volume->slabs_mm3;
    }
    if (found.ledger) {
        c.triangles_between_planes = found.ledger->between;
        c.shells_between_planes = found.ledger->shells.count;
    }
    return c;
}

lamella_view arrays_of(const SliceResult& result) noexcept {
    lamella_view view{};
    view.layers = as_c<lamella_layer>(result.layers.data());
    view.contours = as_c<lamella_contour>(result.contours.data());
    view.points = as_c<lamella_point>(result.points.data());
    view.origins = result.origins.empty() ? nullptr : as_c<lamella_point_origin>(result.origins.data());
    view.stitches = as_c<lamella_stitch>(result.stitches.data());
    view.info = info_of(result.info);
    return view;
}

/// If the struct is of kind T: its defaults, of as many bytes as the program knows.
template <class T>
void init_if(std::int32_t kind, void* it, std::size_t size) noexcept {
    if (kind == Sized<T>::kind) {
        const T whole = defaults<T>();
        std::memcpy(it, &whole, std::min(size, sizeof(T)));
    }
}

}  // namespace

lamella_info info_of(const SliceInfo& info) noexcept {
    lamella_info c{};
    c.struct_size = sizeof c;
    c.grid_doublings = info.grid_doublings;
    c.grid_mm = info.grid_mm;
    copy_box(info.box, c.min_mm, c.max_mm);
    c.stitch_mm = info.options.stitch_mm;
#define COUNTER(name) c.name = info.name;
#include "options/counters.inc"
    c.layer_of = info.layer_of.data();
    c.layer_of_count = info.layer_of.size();
    c.copies = as_c<lamella_part_copy>(info.copies.data());
    c.copy_count = info.copies.size();
    return c;
}

lamella_layer_view view_of(const LayerView& layer) noexcept {
    lamella_layer_view c{};
    c.struct_size = sizeof c;
    c.index = layer.index;
    c.grid_mm = layer.grid_mm;
    c.layer = *as_c<lamella_layer>(static_cast<const Layer*>(&layer));
    c.contours = as_c<lamella_contour>(layer.contours.data());
    c.points = as_c<lamella_point>(layer.points.data());
    c.point_count = layer.points.size();
    c.first_point = layer.first_point;
    c.origins = layer.origins.empty() ? nullptr : as_c<lamella_point_origin>(layer.origins.data());
    c.stitches = as_c<lamella_stitch>(layer.stitches.data());
    c.stitch_count = layer.stitches.size();
    return c;
}

std::int32_t report(const Status& status, lamella_error* error) noexcept {
    auto c = defaults<lamella_error>();
    if (!status) {
        const Error& what = status.error();
        c.status = status_of(what.code);
        c.part = what.part;
        c.triangle = what.triangle;
        c.plane = what.plane;
        c.byte_offset = what.byte_offset;
        c.message[what.message.copy(c.message, sizeof c.message - 1)] = '\0';
    }
    write_sized(c, error);
    return c.status;
}

}  // namespace lamella::c

namespace api = lamella::c;

void lamella_result_view(const lamella_result* result, lamella_view* view) {
    api::write_sized(result == nullptr ? lamella_view{} : api::arrays_of(result->result), view);
}

int32_t lamella_result_layer(const lamella_result* result, uint64_t layer, lamella_layer_view* view) {
    return api::called(nullptr, [&] {
        api::require_initialised(view);
        api::require_given(result, "the result");
        if (layer >= result->result.size()) {
            api::refuse("the result has no such layer");
        }
        api::write_sized(api::view_of(result->result[layer]), view);
    });
}

uint64_t lamella_result_hash(const lamella_result* result) {
    return result == nullptr ? 0 : result->result.hash();
}

void lamella_result_free(lamella_result* result) {
    delete result;
}

double lamella_area_mm2(const lamella_layer_view* layer) {
    if (layer == nullptr) {
        return 0;
    }
    lamella::LayerView view;
    view.contours = lamella::detail::span_of(api::as_cpp(layer->contours), layer->layer.contour_count);
    view.grid_mm = layer->grid_mm;
    return view.area_mm2();
}

double lamella_contour_area_mm2(const lamella_contour* contour, double grid_mm) {
    lamella::LayerView view;
    view.grid_mm = grid_mm;
    return contour == nullptr ? 0 : view.area_mm2(*api::as_cpp(contour));
}

int32_t lamella_next_island(const lamella_contour* contours, uint64_t contour_count, uint64_t* at, lamella_island* island) {
    if (contours == nullptr || at == nullptr || island == nullptr || *at >= contour_count) {
        return 0;
    }
    const std::span<const lamella::Contour> rest =
        lamella::detail::span_of(api::as_cpp(contours) + *at, contour_count - *at);
    const lamella::Islands islands(rest);
    if (islands.begin() == islands.end()) {
        *at = contour_count;
        return 0;
    }
    const lamella::Island found = *islands.begin();
    *island = {api::as_c<lamella_contour>(found.outer), api::as_c<lamella_contour>(found.holes.data()), found.holes.size()};
    *at += static_cast<std::uint64_t>(found.holes.data() + found.holes.size() - rest.data());
    return 1;
}

int32_t lamella_check(const lamella_mesh* mesh, const lamella_options* options, int32_t counts_only,
                      const lamella_context* context, lamella_check_result* found, lamella_error* error) {
    return api::called(error, [&] {
        api::require_initialised(found);
        const api::Host host(context);
        lamella::SliceOptions frame;
        api::read_options(options, frame);
        const bool counts = counts_only != 0;
        const auto check = lamella::require(lamella::check(
            api::read_mesh(mesh), {.frame = frame.frame, .counts_only = counts, .most_places = 0}, host.context));
        api::write_sized(api::check_of(check, counts), found);
    });
}

int32_t lamella_weld(const lamella_mesh* mesh, double tolerance_mm, int32_t orient_shells, const lamella_context* context,
                     lamella_welded** welded, lamella_error* error) {
    return api::called(error, [&] {
        api::require_place(welded, "the welded mesh", "welded");
        const api::Host host(context);
        auto made = lamella::require(lamella::weld(api::read_mesh(mesh), tolerance_mm, host.context));
        if (orient_shells != 0) {
            made = lamella::require(lamella::orient_shells(made.view(), 0, host.context)).mesh;
        }
        auto fresh = std::make_unique<lamella_welded>(lamella_welded{std::move(made)});
        lamella_welded_free(std::exchange(*welded, fresh.release()));
    });
}

void lamella_welded_mesh(const lamella_welded* welded, lamella_mesh* mesh) {
    lamella_mesh c = api::defaults<lamella_mesh>();
    if (welded != nullptr) {
        const lamella::MeshView view = welded->mesh.view();
        c.vertex_type = static_cast<std::int32_t>(view.vertex_type);
        c.vertices = view.vertices;
        c.vertex_count = view.vertex_count;
        c.triangle_count = view.triangle_count;
        c.indices = view.indices;
        c.mm_per_unit = view.mm_per_unit;
    }
    api::write_sized(c, mesh);
}

void lamella_welded_free(lamella_welded* welded) {
    delete welded;
}

int32_t lamella_audit(const lamella_result* result, const lamella_mesh* mesh, const lamella_context* context,
                      lamella_audit_result* found, lamella_error* error) {
    return api::called(error, [&] {
        api::require_initialised(found);
        api::require_given(result, "the result");
        const api::Host host(context);
        const lamella::MeshView view = mesh == nullptr ? lamella::MeshView{} : api::read_mesh(mesh);
        const lamella::AuditOptions all{.volume = mesh != nullptr, .ledger = mesh != nullptr, .structure = true};
        api::write_sized(api::audit_of(lamella::require(lamella::audit(result->result, view, all, host.context))), found);
    });
}

const char* lamella_version(void) {
    return lamella::version;
}

const char* lamella_status_name(int32_t status) {
    const bool known = status >= 0 && static_cast<std::size_t>(status) < std::size(api::status_names);
    return known ? api::status_names[status] : "unknown";
}

void lamella_init_sized(void* it, int32_t kind, size_t size) {
    if (it == nullptr || size < sizeof(std::uint32_t)) {
        return;
    }
    std::memset(it, 0, size);
    api::init_if<lamella_error>(kind, it, size);
    api::init_if<lamella_context>(kind, it, size);
    api::init_if<lamella_mesh>(kind, it, size);
    api::init_if<lamella_options>(kind, it, size);
    api::init_if<lamella_arrays>(kind, it, size);
    api::init_if<lamella_audit_result>(kind, it, size);
    api::init_if<lamella_layer_set>(kind, it, size);
    api::init_if<lamella_rule>(kind, it, size);
    api::init_if<lamella_adaptive>(kind, it, size);
    api::init_if<lamella_offset>(kind, it, size);
    const auto bytes = static_cast<std::uint32_t>(size);
    std::memcpy(it, &bytes, sizeof bytes);
}
