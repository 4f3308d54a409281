// Where the library takes its memory from: the host's functions, or operator new where it gives none.
//
//     lamella::Memory memory = lamella::memory_of(pool);    // pool: a std::pmr::memory_resource, or anything like it
//     options.control.memory = &memory;
#pragma once

#include <cstddef>

namespace lamella {

/// The host's memory. Its functions are called from several threads at once. It must outlive every call that it is passed
/// to and every result whose arrays come from it.
struct Memory {
    /// `bytes` > 0 at a multiple of `alignment`, a power of two; null where there are none.
    void* (*allocate)(void* context, std::size_t bytes, std::size_t alignment) noexcept = nullptr;
    /// Takes back what allocate() gave for the same `bytes` and `alignment`.
    void (*release)(void* context, void* memory, std::size_t bytes, std::size_t alignment) noexcept = nullptr;
    void* context = nullptr;
};

/// Memory from an object with allocate(bytes, alignment), which may throw, and deallocate(memory, bytes, alignment), such as
/// a std::pmr::memory_resource. The object must outlive the Memory.
template <class Resource>
Memory memory_of(Resource& resource) noexcept {
    return {[](void* context, std::size_t bytes, std::size_t alignment) noexcept -> void* {
                try {
                    return static_cast<Resource*>(context)->allocate(bytes, alignment);
                } catch (...) {
                    return nullptr;
                }
            },
            [](void* context, void* memory, std::size_t bytes, std::size_t alignment) noexcept {
                static_cast<Resource*>(context)->deallocate(memory, bytes, alignment);
            },
            &resource};
}

}  // namespace lamella
