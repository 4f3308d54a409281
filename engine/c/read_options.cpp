// Structs that the program fills in, as the C++ ones that they stand for.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>

#include "c/call.hpp"
#include "options/option_words.hpp"

namespace lamella::c {

namespace {

/// The value of a C++ enumeration whose values are 0 to `last`.
template <class Enum>
Enum choice(std::int32_t given, std::int32_t last, const char* name) {
    if (given < 0 || given > last) {
        refuse(std::string(name) + " is " + std::to_string(given) + ", but the choices are 0 to " + std::to_string(last));
    }
    return static_cast<Enum>(given);
}
template <class Enum>
void take(std::int32_t given, const char* name, Enum& to) {
    to = choice<Enum>(given, static_cast<std::int32_t>(detail::words_of(Enum{}).size()) - 1, name);
}
void take(std::int32_t given, const char* /*name*/, bool& to) {
    to = given != 0;
}
void take(double given, const char* /*name*/, double& to) {
    to = given;
}
void take(double given, const char* /*name*/, std::optional<double>& to) {
    to = std::isnan(given) ? std::nullopt : std::optional(given);
}
void take(std::uint64_t given, const char* /*name*/, std::uint64_t& to) {
    to = given;
}
void take(const double (&given)[12], const char* /*name*/, Transform& to) {
    std::copy(std::begin(given), std::end(given), to.m.begin());
}

void require_list(const void* list, std::size_t count, const char* name) {
    if (list == nullptr && count != 0) {
        refuse(std::string(name) + " is NULL, but its count is not 0");
    }
}

void take_heights(const lamella_options& given, std::optional<std::vector<double>>& to) {
    if (given.at_heights == 0) {
        to.reset();
        return;
    }
    require_list(given.heights_mm, given.height_count, "heights_mm");
    if (!to) {
        to.emplace();
    }
    to->assign(given.heights_mm, given.heights_mm + given.height_count);
}

void take_fill_from(const lamella_options& given, std::vector<FillFrom>& to) {
    require_list(given.fill_from, given.fill_from_count, "fill_from");
    to.clear();
    for (std::size_t i = 0; i < given.fill_from_count; ++i) {
        FillFrom& from = to.emplace_back();
        from.first_layer = given.fill_from[i].first_layer;
        take(given.fill_from[i].fill_rule, "fill_rule of fill_from", from.rule);
    }
}

void give(bool value, std::int32_t& to) {
    to = value ? 1 : 0;
}
void give(double value, double& to) {
    to = value;
}
void give(const std::optional<double>& value, double& to) {
    to = value.value_or(std::numeric_limits<double>::quiet_NaN());
}
void give(std::uint64_t value, std::uint64_t& to) {
    to = value;
}
void give(const Transform& value, double (&to)[12]) {
    std::copy(value.m.begin(), value.m.end(), to);
}
template <class Enum>
void give(Enum value, std::int32_t& to) {
    to = static_cast<std::int32_t>(value);
}

template <class T>
T sized() noexcept {
    T it{};
    it.struct_size = sizeof it;
    return it;
}

}  // namespace

lamella_context default_context() noexcept {
    auto context = sized<lamella_context>();
    context.executor_threads = 1;
    return context;
}

lamella_mesh default_mesh() noexcept {
    auto mesh = sized<lamella_mesh>();
    mesh.mm_per_unit = 1;
    mesh.index_type = LAMELLA_U32;
    return mesh;
}

lamella_options default_options() noexcept {
    const SliceOptions defaults;
    auto options = sized<lamella_options>();
#define OPTION(kind, name, path, ...) LAMELLA_GIVE_##kind(name, path)
#define LAMELLA_GIVE_heights(name, path)
#define LAMELLA_GIVE_fill_from(name, path)
#define LAMELLA_GIVE_mm(name, path) give(defaults.path, options.name);
#define LAMELLA_GIVE_number LAMELLA_GIVE_mm
#define LAMELLA_GIVE_flag LAMELLA_GIVE_mm
#define LAMELLA_GIVE_count LAMELLA_GIVE_mm
#define LAMELLA_GIVE_choice LAMELLA_GIVE_mm
#define LAMELLA_GIVE_optional_mm LAMELLA_GIVE_mm
#define LAMELLA_GIVE_transform LAMELLA_GIVE_mm
#include "options/options.inc"
    return options;
}

void read_options(const lamella_options* given, SliceOptions& options) {
    const lamella_options c = read_sized(given, default_options());
    if (c.reserved_0_3 != 0) {
        refuse("lamella_options has a field set that lamella " + std::string(version) + " does not know");
    }
#define OPTION(kind, name, path, ...) LAMELLA_TAKE_##kind(name, path)
#define LAMELLA_TAKE_heights(name, path) take_heights(c, options.path);
#define LAMELLA_TAKE_fill_from(name, path) take_fill_from(c, options.path);
#define LAMELLA_TAKE_mm(name, path) take(c.name, #name, options.path);
#define LAMELLA_TAKE_number LAMELLA_TAKE_mm
#define LAMELLA_TAKE_flag LAMELLA_TAKE_mm
#define LAMELLA_TAKE_count LAMELLA_TAKE_mm
#define LAMELLA_TAKE_choice LAMELLA_TAKE_mm
#define LAMELLA_TAKE_optional_mm LAMELLA_TAKE_mm
#define LAMELLA_TAKE_transform LAMELLA_TAKE_mm
#include "options/options.inc"
}

MeshView read_mesh(const lamella_mesh* given) {
    if (given == nullptr) {
        refuse("the mesh is NULL");
    }
    const lamella_mesh c = read_sized(given, default_mesh());
    if (c.index_type != LAMELLA_U32 && c.index_type != LAMELLA_U64) {
        refuse("index_type is " + std::to_string(c.index_type) + ", but the choices are LAMELLA_U32 and LAMELLA_U64");
    }
    require_list(c.vertices, c.triangle_count, "vertices");
    return {.vertices = c.vertices,
            .vertex_count = c.vertex_count,
            .triangle_count = c.triangle_count,
            .indices = c.indices,
            .vertex_stride = c.vertex_stride,
            .index_stride = c.index_stride,
            .vertex_type = choice<Number>(c.vertex_type, LAMELLA_I64, "vertex_type"),
            .index_type = static_cast<Number>(c.index_type),
            .mm_per_unit = c.mm_per_unit};
}

Host::Host(const lamella_context* given) : c_(read_sized(given, default_context())) {
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
