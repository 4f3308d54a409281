#include "lamella/array.hpp"

#include <new>

#include <sys/mman.h>

namespace lamella::detail {

namespace {

constexpr std::size_t huge_page = std::size_t{1} << 21;
constexpr std::size_t cache_line = 64;

/// Blocks of a few huge pages and more are worth aligning for them.
std::align_val_t alignment_for(std::size_t bytes) {
    return std::align_val_t{bytes >= 2 * huge_page ? huge_page : cache_line};
}

}  // namespace

void* take_memory(std::pmr::memory_resource* resource, std::size_t bytes) {
    if (bytes == 0) {
        return nullptr;
    }
    if (resource != nullptr) {
        return resource->allocate(bytes, cache_line);
    }
    void* memory = ::operator new(bytes, alignment_for(bytes));
    if (bytes >= 2 * huge_page) {
        // Advice only: where the kernel has no huge pages to give, small ones serve.
        (void)::madvise(memory, bytes / huge_page * huge_page, MADV_HUGEPAGE);
    }
    return memory;
}

void give_memory(std::pmr::memory_resource* resource, void* memory, std::size_t bytes) noexcept {
    if (memory == nullptr) {
        return;
    }
    if (resource != nullptr) {
        resource->deallocate(memory, bytes, cache_line);
    } else {
        ::operator delete(memory, alignment_for(bytes));
    }
}

}  // namespace lamella::detail
