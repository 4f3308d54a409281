// Arrays of numbers as binary files hold them: of any type, in either byte order, at any address.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lamella/mesh.hpp"

namespace lamella {

enum class NumberType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

constexpr std::size_t bytes_of(NumberType type) noexcept {
    constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

constexpr bool is_integer(NumberType type) noexcept {
    return type < NumberType::float32;
}

/// Where the numbers of an array stand, for messages about one of them.
struct NumberPlace {
    enum class Form : std::uint8_t {
        text,    ///< as words; the first is at `offset`
        bytes,   ///< as they are, from `offset` on
        encoded  ///< in base64 or compressed, in the element at `offset`
    };
    Form form = Form::bytes;
    std::uint64_t offset = 0;  ///< in the file
};

struct NumberArray {
    const std::byte* data = nullptr;
    std::uint64_t count = 0;
    NumberType type = NumberType::float32;
    bool big_endian = false;
    NumberPlace place;
};

/// The integers [first, first + count) in 64 bits; what is negative becomes more than 2^63.
/// Precondition: is_integer(numbers.type), and the range lies within.
void decode_integers(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, std::uint64_t* out);

/// The same in 32 bits. Returns the largest in 64: if it does not fit, `out` does not hold what is in the array.
std::uint64_t decode_indices(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, std::uint32_t* out);

/// The numbers [first, first + count) as floats or doubles, without alignment. `out` may be where they lie if they are such.
void decode_coordinates(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, CoordinateType as,
                        std::byte* out);

}  // namespace lamella
