// Memory for a call whose large arrays come and go: what one has given back the next one gets. The system clears each page
// that it hands out, which cost up to a third of check()'s time where every array took fresh ones.
#pragma once

#include <cstddef>
#include <mutex>
#include <vector>

#include "lamella/memory.hpp"

namespace lamella {

/// Small blocks come from operator new. Gives everything back at its end, when no block may be in use any more.
class Recycler {
public:
    Recycler() = default;
    ~Recycler();
    Recycler(const Recycler&) = delete;
    Recycler& operator=(const Recycler&) = delete;

    const Memory* memory() const noexcept { return &memory_; }

    /// For memory_of(). O(free blocks). Throws std::bad_alloc.
    void* allocate(std::size_t bytes, std::size_t alignment);
    void deallocate(void* block, std::size_t bytes, std::size_t alignment) noexcept;

private:
    /// Stands at its own beginning.
    struct Free {
        std::size_t bytes;
        Free* next;  ///< at the next higher address
    };
    struct Taken {
        void* block;
        std::size_t bytes;
    };

    Free* take_fitting(std::size_t bytes) noexcept;

    std::mutex mutex_;
    Free* first_ = nullptr;
    std::vector<Taken> taken_;
    const Memory memory_ = memory_of(*this);
};

}  // namespace lamella
