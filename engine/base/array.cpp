#include "lamella/array.hpp"
#include "lamella/memory.hpp"

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

void* take_memory(const Memory* memory, std::size_t bytes) {
    if (bytes == 0) {
        return nullptr;
    }
    if (memory != nullptr) {
        void* const block = memory->allocate(memory->context, bytes, cache_line);
        if (block == nullptr) {
            throw std::bad_alloc();
        }
        return block;
    }
    void* const block = ::operator new(bytes, alignment_for(bytes));
    if (bytes >= 2 * huge_page) {
        // Advice only: where the kernel has no huge pages to give, small ones serve.
        (void)::madvise(block, bytes / huge_page * huge_page, MADV_HUGEPAGE);
    }
    return block;
}

void give_memory(const Memory* memory, void* block, std::size_t bytes) noexcept {
    if (block == nullptr) {
        return;
    }
    if (memory != nullptr) {
        memory->release(memory->context, block, bytes, cache_line);
    } else {
        ::operator delete(block, alignment_for(bytes));
    }
}

}  // namespace lamella::detail
