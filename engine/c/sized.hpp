// Structs that begin with their size. A program that was compiled with an older header fills in only the beginning: the rest
// has its defaults. A program with a newer header has fields that the library does not know: they must be 0, since what they
// ask for would not be done.
//
//     the program's      [ size | a | b ]           [ size | a | b | c | d ]
//     the library's      [ size | a | b | c ]       [ size | a | b | c ]
//                                      ^ default                      ^ 0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>

#include "lamella/error.hpp"
#include "lamella/lamella.h"
#include "lamella/slice.hpp"
#include "lamella/version.hpp"

namespace lamella::c {

/// No version of a struct is larger: what is was not initialised.
inline constexpr std::size_t largest_struct = 4096;

/// Where the last field of T ends.
template <class T>
inline constexpr std::size_t end_of_fields = 0;

#define LAMELLA_LAST_FIELD(T, field) \
    template <>                      \
    inline constexpr std::size_t end_of_fields<T> = (offsetof(T, field) + sizeof(T::field))
LAMELLA_LAST_FIELD(lamella_error, message);
LAMELLA_LAST_FIELD(lamella_control, progress_context);
LAMELLA_LAST_FIELD(lamella_mesh, coordinate_mm);
LAMELLA_LAST_FIELD(lamella_region_rules, simplify_mm);
LAMELLA_LAST_FIELD(lamella_options, reserved);
LAMELLA_LAST_FIELD(lamella_view, origins);
LAMELLA_LAST_FIELD(lamella_totals, layer_of_capacity);
LAMELLA_LAST_FIELD(lamella_output_bounds, unit_mm);
LAMELLA_LAST_FIELD(lamella_host_output, origins);
#undef LAMELLA_LAST_FIELD

/// Sets the defaults that are not 0.
struct Defaults {
    template <class T>
    static void set(T&) noexcept {}
    static void set(lamella_error& error) noexcept { error.triangle = error.plane = error.byte_offset = -1; }
    static void set(lamella_control& control) noexcept { control.executor_threads = 1; }
    static void set(lamella_mesh& mesh) noexcept { mesh.coordinate_mm = 1; }
    static void set(lamella_region_rules& rules) noexcept { rules.miter_limit = RegionRules{}.miter_limit; }
    static void set(lamella_host_output& output) noexcept { output.scale = 1; }
    static void set(lamella_options& options) noexcept {
        options.layer_height_mm = UniformLayers{}.layer_height_mm;
        options.first_height_mm = std::numeric_limits<double>::quiet_NaN();
        const Transform identity;
        std::copy(identity.m.begin(), identity.m.end(), options.transform);
    }
};

template <class T>
T defaults() noexcept {
    T all{};
    all.struct_size = sizeof all;
    Defaults::set(all);
    return all;
}

template <class T>
constexpr void check_sized() {
    static_assert(std::is_standard_layout_v<T> && std::is_trivially_copyable_v<T>, "what C can read");
    static_assert(offsetof(T, struct_size) == 0, "the size comes first");
    static_assert(end_of_fields<T> == sizeof(T),
                  "a field of a later version must not lie where programs of this one leave padding unset");
}

/// The defaults, into a struct of `size` bytes.
template <class T>
void init_sized(T* out, std::size_t size) noexcept {
    check_sized<T>();
    const T all = defaults<T>();
    std::memset(out, 0, size);
    std::memcpy(out, &all, std::min(size, sizeof(T)));
    out->struct_size = static_cast<std::uint32_t>(size);
}

/// invalid_argument where what the library does not know is set.
template <class T>
Status check_unknown(const T* given, std::size_t size, const T& known, const char* name) {
    const auto* const bytes = reinterpret_cast<const unsigned char*>(given);
    bool set = size > sizeof(T) && std::any_of(bytes + sizeof(T), bytes + size, [](unsigned char b) { return b != 0; });
    if constexpr (requires { known.reserved; }) {
        set = set || known.reserved != 0;
    }
    if (!set) {
        return {};
    }
    return Error{ErrorCode::invalid_argument, std::string(name) + " has a field set that lamella " + version +
                                                  " does not know: initialise it by " + name +
                                                  "_init(), or use a later version of the library"};
}

/// Reads what the program gave, and the defaults beyond; all defaults where it gave nothing.
template <class T>
Status read_sized(const T* given, const char* name, T& whole) {
    check_sized<T>();
    whole = defaults<T>();
    if (given == nullptr) {
        return {};
    }
    std::uint32_t size = 0;
    std::memcpy(&size, given, sizeof size);
    if (size < 2 * sizeof size || size > largest_struct) {
        return Error{ErrorCode::invalid_argument, std::string("struct_size of ") + name + " is " + std::to_string(size) +
                                                      ": initialise it by " + name + "_init()"};
    }
    std::memcpy(&whole, given, std::min<std::size_t>(size, sizeof(T)));
    return check_unknown(given, size, whole, name);
}

/// As much of `value` as the program's struct holds.
template <class T>
void write_sized(const T& value, T* out) noexcept {
    check_sized<T>();
    if (out != nullptr) {
        const std::uint32_t size = out->struct_size;
        std::memcpy(out, &value, std::min<std::size_t>(size, sizeof(T)));
        out->struct_size = size;
    }
}

}  // namespace lamella::c
