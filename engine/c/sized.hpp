// Structs that begin with their size. A program that was compiled with an older header fills in only the beginning: the rest
// has its defaults. A program with a newer header has more than the library knows, and what is beyond is left alone.
//
//     the program's      [ size | a | b ]           [ size | a | b | c | d ]
//     the library's      [ size | a | b | c ]       [ size | a | b | c ]
//                                      ^ default
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

#include "lamella/error.hpp"

namespace lamella::c {

template <class T>
constexpr void check_sized() {
    static_assert(std::is_standard_layout_v<T> && std::is_trivially_copyable_v<T>, "what C can read");
    static_assert(offsetof(T, struct_size) == 0, "the size comes first");
}

/// The defaults, into a struct of `size` bytes.
template <class T>
void init_sized(T* out, std::size_t size, const T& defaults) noexcept {
    check_sized<T>();
    std::memset(out, 0, size);
    std::memcpy(out, &defaults, std::min(size, sizeof(T)));
    out->struct_size = static_cast<std::uint32_t>(size);
}

/// What the program gave, and the defaults beyond; all defaults where it gave nothing.
template <class T>
Status read_sized(const T* given, const T& defaults, const char* name, T& whole) {
    check_sized<T>();
    whole = defaults;
    if (given == nullptr) {
        return {};
    }
    std::uint32_t size = 0;
    std::memcpy(&size, given, sizeof size);
    if (size < 2 * sizeof size) {
        return Error{ErrorCode::invalid_argument, std::string("struct_size of ") + name + " is " + std::to_string(size) +
                                                      ": initialise it by " + name + "_init()"};
    }
    std::memcpy(&whole, given, std::min<std::size_t>(size, sizeof(T)));
    return {};
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
