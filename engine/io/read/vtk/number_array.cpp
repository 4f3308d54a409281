#include "io/read/vtk/number_array.hpp"

#include "base/little_endian.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>
#include <type_traits>

namespace lamella {

namespace {

/// The unsigned type of the size of `T`.
template <class T>
using Bits = std::conditional_t<
    sizeof(T) == 1, std::uint8_t,
    std::conditional_t<sizeof(T) == 2, std::uint16_t, std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;

template <class T>
T swapped(T value) {
    const auto bits = std::bit_cast<Bits<T>>(value);
    if constexpr (sizeof(T) == 2) {
        return std::bit_cast<T>(__builtin_bswap16(bits));
    } else if constexpr (sizeof(T) == 4) {
        return std::bit_cast<T>(__builtin_bswap32(bits));
    } else if constexpr (sizeof(T) == 8) {
        return std::bit_cast<T>(__builtin_bswap64(bits));
    } else {
        return value;
    }
}

template <class T, bool big_endian>
struct Values {
    const std::byte* data;

    T operator[](std::uint64_t i) const {
        T value;
        std::memcpy(&value, data + i * sizeof(T), sizeof(T));
        return big_endian ? swapped(value) : value;
    }
};

template <class T, class Use>
void use_as(const NumberArray& numbers, std::uint64_t first, const Use& use) {
    const std::byte* data = numbers.data + first * sizeof(T);
    if (numbers.big_endian && sizeof(T) > 1) {
        use(Values<T, true>{data});
    } else {
        use(Values<T, false>{data});
    }
}

/// Calls `use` with the numbers from `first` on, in their type.
template <class Use>
void use_integers(const NumberArray& numbers, std::uint64_t first, const Use& use) {
    switch (numbers.type) {
        case NumberType::int8:
            return use_as<std::int8_t>(numbers, first, use);
        case NumberType::uint8:
            return use_as<std::uint8_t>(numbers, first, use);
        case NumberType::int16:
            return use_as<std::int16_t>(numbers, first, use);
        case NumberType::uint16:
            return use_as<std::uint16_t>(numbers, first, use);
        case NumberType::int32:
            return use_as<std::int32_t>(numbers, first, use);
        case NumberType::uint32:
            return use_as<std::uint32_t>(numbers, first, use);
        case NumberType::int64:
            return use_as<std::int64_t>(numbers, first, use);
        case NumberType::uint64:
            return use_as<std::uint64_t>(numbers, first, use);
        case NumberType::float32:
        case NumberType::float64:
            break;
    }
    assert(false && "no integers");
}

template <class Out>
void decode(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, std::byte* out) {
    const auto copy = [&](auto values) {
        for (std::uint64_t i = 0; i < count; ++i) {
            const Out value = static_cast<Out>(values[i]);
            std::memcpy(out + i * sizeof(Out), &value, sizeof(Out));
        }
    };
    switch (numbers.type) {
        case NumberType::float32:
            return use_as<float>(numbers, first, copy);
        case NumberType::float64:
            return use_as<double>(numbers, first, copy);
        default:
            return use_integers(numbers, first, copy);
    }
}

}  // namespace

void decode_integers(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, std::uint64_t* out) {
    use_integers(numbers, first, [&](auto values) {
        for (std::uint64_t i = 0; i < count; ++i) {
            out[i] = static_cast<std::uint64_t>(values[i]);  // NOLINT(bugprone-signed-char-misuse): -1 stays -1
        }
    });
}

std::uint64_t decode_indices(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, std::uint32_t* out) {
    std::uint64_t largest = 0;
    use_integers(numbers, first, [&](auto values) {
        using Value = decltype(values[0]);
        // In the type's own width, so that vectors hold more of them; four, so that none waits for another.
        std::array<Bits<Value>, 4> most{};
        const auto decode_one = [&](std::uint64_t i, std::size_t lane) {
            const Value value = values[i];
            out[i] = static_cast<std::uint32_t>(value);  // NOLINT(bugprone-signed-char-misuse): -1 stays -1
            most[lane] = std::max(most[lane], static_cast<Bits<Value>>(value));
        };
        std::uint64_t i = 0;
        for (; i + most.size() <= count; i += most.size()) {
            for (std::size_t lane = 0; lane < most.size(); ++lane) {
                decode_one(i + lane, lane);
            }
        }
        for (; i < count; ++i) {
            decode_one(i, 0);
        }
        const auto signed_most = static_cast<Value>(*std::max_element(most.begin(), most.end()));
        largest = static_cast<std::uint64_t>(signed_most);  // NOLINT(bugprone-signed-char-misuse): -1 stays -1
    });
    return largest;
}

void decode_coordinates(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, CoordinateType as,
                        std::byte* out) {
    if (as == CoordinateType::f32) {
        decode<float>(numbers, first, count, out);
    } else {
        decode<double>(numbers, first, count, out);
    }
}

}  // namespace lamella
