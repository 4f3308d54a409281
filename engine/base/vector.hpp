// std::vector over the host's memory.
#pragma once

#include <cstddef>
#include <limits>
#include <new>
#include <type_traits>
#include <vector>

#include "lamella/array.hpp"
#include "lamella/context.hpp"

namespace lamella {

/// Takes from `memory`, or from operator new where it is null, with huge pages for large blocks.
template <class T>
class Allocator {
public:
    using value_type = T;
    using propagate_on_container_move_assignment = std::true_type;
    using propagate_on_container_swap = std::true_type;

    // Implicit, as a vector is constructed from where its memory comes from.
    Allocator(const Memory* memory = nullptr) noexcept : memory_(memory) {}  // NOLINT(google-explicit-constructor)
    template <class U>
    Allocator(const Allocator<U>& other) noexcept : memory_(other.memory()) {}  // NOLINT(google-explicit-constructor)

    T* allocate(std::size_t count) {
        if (count > std::numeric_limits<std::size_t>::max() / element_bytes) {
            throw std::bad_array_new_length();
        }
        return static_cast<T*>(detail::take_memory(memory_, count * element_bytes));
    }
    void deallocate(T* taken, std::size_t count) noexcept { detail::give_memory(memory_, taken, count * element_bytes); }

    const Memory* memory() const noexcept { return memory_; }
    friend bool operator==(const Allocator&, const Allocator&) = default;

private:
    static constexpr std::size_t element_bytes = sizeof(T);  // NOLINT(bugprone-sizeof-expression): pointers are elements too
    static_assert(alignof(T) <= alignof(std::max_align_t), "operator new aligns no further");
    const Memory* memory_;
};

template <class T>
using Vector = std::vector<T, Allocator<T>>;

/// True where one has room for more than twice what it holds.
template <class... Arrays>
bool any_has_slack(const Arrays&... arrays) noexcept {
    constexpr std::size_t few = 64;
    return ((arrays.capacity() > 2 * arrays.size() + few) || ...);
}

/// Room for `size` elements, and for somewhat more where there was less: the next layer has about as many.
template <class T>
void reserve_more(Vector<T>& array, std::size_t size) {
    if (array.capacity() < size) {
        array.reserve(size + size / 2);
    }
}

}  // namespace lamella
