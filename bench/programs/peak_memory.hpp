// Memory for one thread that records how many bytes were held at most.
#pragma once

#include <algorithm>
#include <cstddef>
#include <new>

#include "lamella/memory.hpp"

namespace lamella::bench {

class PeakMemory : public Memory {
public:
    PeakMemory() : Memory(memory_of(*this)) {}
    std::size_t peak() const noexcept { return peak_; }

    void* allocate(std::size_t bytes, std::size_t alignment) {
        held_ += bytes;
        peak_ = std::max(peak_, held_);
        return ::operator new (bytes, std::align_val_t{alignment});
    }
    void deallocate(void* memory, std::size_t bytes, std::size_t alignment) {
        held_ -= bytes;
        ::operator delete (memory, std::align_val_t{alignment});
    }

private:
    std::size_t held_ = 0;
    std::size_t peak_ = 0;
};

}  // namespace lamella::bench
