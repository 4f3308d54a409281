#include "lamella/array.hpp"

#include <new>

#include "base/system/machine.hpp"
#include "lamella/context.hpp"

namespace lamella::detail {

namespace {

constexpr std::size_t huge_page = std::size_t{1} << 21;
constexpr std::size_t cache_line = 64;

/// A quarter of a huge page is worth one: a page of 4 KB that is touched first costs 2 to 15 us, and all 512 of a huge page
/// 0.2 to 0.3 ms.
constexpr std::size_t worth_a_page = huge_page / 4;

bool takes_huge_pages(std::size_t bytes) {
    return bytes >= worth_a_page;
}
std::align_val_t alignment_for(std::size_t bytes) {
    return std::align_val_t{takes_huge_pages(bytes) ? huge_page : cache_line};
}

/// The bytes taken for them: a last page that is worth one, or little beside the others, is filled up.
std::size_t whole_pages(std::size_t bytes) {
    const std::size_t rest = bytes % huge_page;
    return takes_huge_pages(bytes) && (rest >= worth_a_page || bytes >= 8 * huge_page) ? bytes + (huge_page - rest) : bytes;
}

}  // namespace

void* take_memory(const Memory* memory, std::size_t bytes) {
    if (bytes == 0) {
        return nullptr;
    }
    if (memory != nullptr) {
        void* const block = memory->allocate(bytes, cache_line);
        if (block == nullptr) {
            throw std::bad_alloc();
        }
        return block;
    }
    const std::size_t taken = whole_pages(bytes);
    void* const block = ::operator new(taken, alignment_for(bytes));
    if (takes_huge_pages(bytes)) {
        advise_huge_pages(block, taken / huge_page * huge_page);
    }
    return block;
}

void give_memory(const Memory* memory, void* block, std::size_t bytes) noexcept {
    if (block == nullptr) {
        return;
    }
    if (memory != nullptr) {
        memory->release(block, bytes, cache_line);
    } else {
        ::operator delete(block, alignment_for(bytes));
    }
}

}  // namespace lamella::detail
