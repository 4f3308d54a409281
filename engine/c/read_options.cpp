// Structs that the program fills in, as the C++ ones that they stand for.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <string>

#include "c/call.hpp"
#include "options/option_words.hpp"

namespace lamella::c {

namespace {

/// A choice by its number; NaN is a number that is not given.
template <class Given, class Option>
void take(const lamella_options& /*all*/, const Given& given, const char* name, Option& to) {
    if constexpr (std::is_enum_v<Option>) {
        require_choice(given, static_cast<std::int32_t>(detail::words_of(to).size()) - 1, name);
        to = static_cast<Option>(given);
    } else if constexpr (std::is_same_v<Option, bool>) {
        to = given != 0;
    } else if constexpr (std::is_same_v<Option, std::optional<double>>) {
        to = std::isnan(given) ? std::nullopt : std::optional(given);
    } else if constexpr (std::is_same_v<Option, Transform>) {
        std::copy(std::begin(given), std::end(given), to.m.begin());
    } else {
        static_assert(std::is_same_v<Option, Given>);
        to = given;
    }
}

void take(const lamella_options& all, const double* given, const char* name, std::optional<std::vector<double>>& to) {
    if (all.at_heights == 0) {
        to.reset();
        return;
    }
    require_list(given, all.height_count, name);
    if (!to) {
        to.emplace();
    }
    to->assign(given, given + all.height_count);
}

void take(const lamella_options& all, const lamella_slab* given, const char* name, std::vector<Slab>& to) {
    require_list(given, all.slab_count, name);
    to.assign(as_cpp(given), as_cpp(given) + all.slab_count);
}

void take(const lamella_options& all, const lamella_fill_from* given, const char* name, std::vector<FillFrom>& to) {
    require_list(given, all.fill_from_count, name);
    to.clear();
    for (std::size_t i = 0; i < all.fill_from_count; ++i) {
        FillFrom& from = to.emplace_back();
        from.first_layer = given[i].first_layer;
        take(all, given[i].fill_rule, "fill_rule of fill_from", from.rule);
    }
}

/// The reverse; lists are empty by default.
template <class Option, class Given>
void give(const Option& value, Given& to) {
    if constexpr (std::is_same_v<Option, std::optional<double>>) {
        to = value.value_or(std::numeric_limits<double>::quiet_NaN());
    } else if constexpr (std::is_same_v<Option, Transform>) {
        std::copy(value.m.begin(), value.m.end(), to);
    } else if constexpr (!std::is_pointer_v<Given>) {
        to = static_cast<Given>(value);
    }
}

}  // namespace

void require_given(const void* given, const std::string& what) {
    if (given == nullptr) {
        refuse(what + " is NULL");
    }
}

void require_list(const void* list, std::size_t count, const char* name) {
    if (list == nullptr && count != 0) {
        refuse(std::string(name) + " is NULL, but its count is not 0");
    }
}

void require_choice(std::int32_t given, std::int32_t last, const char* name) {
    if (given < 0 || given > last) {
        refuse(std::string(name) + " is " + std::to_string(given) + ", but the choices are 0 to " + std::to_string(last));
    }
}

void require_one(std::initializer_list<const void*> given, const char* fields) {
    const auto set = std::count_if(given.begin(), given.end(), [](const void* field) { return field != nullptr; });
    if (set != 1) {
        refuse("of " + std::string(fields) + " exactly one must be set, and " + std::to_string(set) + " are");
    }
}

std::uint32_t size_given(const void* given, const char* name, const char* init) {
    std::uint32_t size = 0;
    if (given == nullptr) {
        return size;
    }
    std::memcpy(&size, given, sizeof size);
    if (size < 2 * sizeof size || size > largest_struct) {
        refuse("struct_size of " + std::string(name) + " is " + std::to_string(size) + ": initialise it by " + init);
    }
    return size;
}

void copy_given(const void* given, void* whole, std::size_t bytes, const std::int32_t* reserved, const char* name,
                const char* init) {
    const std::uint32_t size = size_given(given, name, init);
    if (size == 0) {
        return;
    }
    std::memcpy(whole, given, std::min<std::size_t>(size, bytes));
    const auto* const at = static_cast<const unsigned char*>(given);
    const bool beyond = size > bytes && std::any_of(at + bytes, at + size, [](unsigned char b) { return b != 0; });
    if (beyond || (reserved != nullptr && *reserved != 0)) {
        refuse(std::string(name) + " has a field set that lamella " + version + " does not know: initialise it by " + init +
               ", or use a later version of the library");
    }
}

void set_defaults(lamella_error& error) noexcept {
    error.part = error.triangle = error.plane = error.byte_offset = -1;
}

void set_defaults(lamella_context& context) noexcept {
    context.executor_threads = 1;
}

void set_defaults(lamella_mesh& mesh) noexcept {
    mesh.mm_per_unit = 1;
    mesh.index_type = LAMELLA_U32;
}

void set_defaults(lamella_arrays& arrays) noexcept {
    arrays.point_type = LAMELLA_I32;
    arrays.scale = 1;
}

void set_defaults(lamella_audit_result& found) noexcept {
    found.volume = LAMELLA_VOLUME_NOT_ASKED;
    found.structure = -1;
    found.mesh_mm3 = found.slabs_mm3 = std::numeric_limits<double>::quiet_NaN();
}

void set_defaults(lamella_adaptive& adaptive) noexcept {
    const AdaptiveOptions cpp;
    adaptive.least_mm = cpp.least_mm;
    adaptive.most_mm = cpp.most_mm;
    adaptive.step_mm = cpp.step_mm;
}

void set_defaults(lamella_options& options) noexcept {
    const SliceOptions cpp;
#define OPTION(kind, name, path, ...) give(cpp.path, options.name);
#include "options/options.inc"
}

void read_options(const lamella_options* given, SliceOptions& options) {
    const lamella_options c = read_sized(given);
#define OPTION(kind, name, path, ...) take(c, c.name, #name, options.path);
#include "options/options.inc"
}

MeshView read_mesh(const lamella_mesh* given) {
    require_given(given, "the mesh");
    const lamella_mesh c = read_sized(given);
    if (c.index_type != LAMELLA_U32 && c.index_type != LAMELLA_U64) {
        refuse("index_type is " + std::to_string(c.index_type) + ", but the choices are LAMELLA_U32 and LAMELLA_U64");
    }
    require_list(c.vertices, c.triangle_count, "vertices");
    require_choice(c.vertex_type, LAMELLA_I64, "vertex_type");
    return {.vertices = c.vertices,
            .vertex_count = c.vertex_count,
            .triangle_count = c.triangle_count,
            .indices = c.indices,
            .vertex_stride = c.vertex_stride,
            .index_stride = c.index_stride,
            .vertex_type = static_cast<Number>(c.vertex_type),
            .index_type = static_cast<Number>(c.index_type),
            .mm_per_unit = c.mm_per_unit};
}

std::vector<std::span<const Point>> read_paths(const lamella_path* contours, std::size_t count) {
    require_list(contours, count, "contours");
    std::vector<std::span<const Point>> paths;
    for (std::size_t i = 0; i < count; ++i) {
        require_list(contours[i].points, contours[i].count, "points of a contour");
        paths.emplace_back(as_cpp(contours[i].points), contours[i].count);
    }
    return paths;
}

Host::Host(const lamella_context* given) : c_(read_sized(given)) {
    context.threads = c_.threads;
    context.memory = as_cpp(c_.memory);
    context.memory_limit_bytes = c_.memory_limit_bytes;
    context.executor_threads = c_.executor_threads;
    if (c_.stop != nullptr) {
        context.stop = {&c_, [](void* self) noexcept {
                            const auto& c = *static_cast<const lamella_context*>(self);
                            return c.stop(c.stop_object) != 0;
                        }};
    }
    if (c_.progress != nullptr) {
        context.progress = {&c_, [](void* self, double fraction) noexcept {
                                const auto& c = *static_cast<const lamella_context*>(self);
                                c.progress(c.progress_object, fraction);
                            }};
    }
    if (c_.executor != nullptr) {
        context.executor = {&c_, [](void* self, int workers, Callback<void()> body) noexcept {
                                const auto& c = *static_cast<const lamella_context*>(self);
                                c.executor(
                                    c.executor_object, workers,
                                    [](void* argument) { (*static_cast<const Callback<void()>*>(argument))(); }, &body);
                            }};
    }
}

}  // namespace lamella::c
