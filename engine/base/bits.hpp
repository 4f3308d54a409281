// The same bits as another type. std::bit_cast would be it, but libc++ 13, which emscripten 3.1 has, lacks it.
#pragma once

#include <type_traits>

namespace lamella {

template <class To, class From>
constexpr To bits_as(const From& from) noexcept {
    static_assert(sizeof(To) == sizeof(From) && std::is_trivially_copyable_v<To> && std::is_trivially_copyable_v<From>);
    return __builtin_bit_cast(To, from);
}

}  // namespace lamella
