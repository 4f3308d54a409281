// Numbers as binary files hold them: of any type, in either byte order, at any address.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "base/little_endian.hpp"
#include "base/numbers.hpp"
#include "base/system/processor.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

enum class NumberType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

constexpr std::size_t size_of(NumberType type) noexcept {
    constexpr std::array<std::size_t, 10> sizes = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

constexpr bool is_integer(NumberType type) noexcept {
    return type < NumberType::float32;
}

/// Calls `f` with a value of the type, whose number does not matter.
template <class F>
decltype(auto) with_type(NumberType type, F&& f) {
    switch (type) {
        case NumberType::int8:
            return f(std::int8_t{});
        case NumberType::uint8:
            return f(std::uint8_t{});
        case NumberType::int16:
            return f(std::int16_t{});
        case NumberType::uint16:
            return f(std::uint16_t{});
        case NumberType::int32:
            return f(std::int32_t{});
        case NumberType::uint32:
            return f(std::uint32_t{});
        case NumberType::int64:
            return f(std::int64_t{});
        case NumberType::uint64:
            return f(std::uint64_t{});
        case NumberType::float32:
            return f(float{});
        case NumberType::float64:
            break;
    }
    return f(double{});
}

/// The unsigned type of the size of `T`.
template <class T>
using Bits = std::conditional_t<
    sizeof(T) == 1, std::uint8_t,
    std::conditional_t<sizeof(T) == 2, std::uint16_t, std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;

/// The number at `p`, whose bytes are reversed if `swapped`.
template <class T>
T load_number(const void* p, bool swapped) {
    Bits<T> bits;
    std::memcpy(&bits, p, sizeof bits);
    return bits_as<T>(swapped ? reversed_bytes(bits) : bits);
}

}  // namespace lamella
