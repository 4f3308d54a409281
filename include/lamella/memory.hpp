// Where the library takes its memory from: the host's functions, or operator new where the host gives none.
//
//     struct Pool {  // a std::pmr::memory_resource, or anything that has these two functions
//         void* allocate(std::size_t bytes, std::size_t alignment) { return std::aligned_alloc(alignment, bytes); }
//         void deallocate(void* memory, std::size_t, std::size_t) { std::free(memory); }
//     } pool;
//     const lamella::Memory memory = lamella::memory_of(pool);
//     const lamella::Result<lamella::SliceResult> sliced = lamella::slice(mesh, {.control = {.memory = &memory}});
//
// control.hpp lists which calls take what from it. With exceptions, which take operator new: the list of contours in a plane
// that all threads work on together; the heights of planes that are not uniform; of several parts 8 bytes a layer; the fill
// rules by layer that a result repeats; the texts of errors and warnings; and objects of a fixed size, some a call, a thread
// and a band.
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
