// Memory that records how many bytes were held at most.
#pragma once

#include <atomic>
#include <cstddef>
#include <new>

#include "lamella/memory.hpp"

class CountingMemory : public lamella::Memory {
public:
    /// An allocation that would exceed `limit` bytes in total fails.
    explicit CountingMemory(std::size_t limit = ~std::size_t{0}) : Memory(lamella::memory_of(*this)), limit_(limit) {}
    std::size_t peak() const { return peak_; }
    std::size_t held() const { return held_; }

    void* allocate(std::size_t bytes, std::size_t alignment) {
        const std::size_t held = held_ += bytes;
        if (held > limit_) {
            held_ -= bytes;
            throw std::bad_alloc();
        }
        std::size_t peak = peak_;
        while (held > peak && !peak_.compare_exchange_weak(peak, held)) {
        }
        return ::operator new (bytes, std::align_val_t{alignment});
    }
    void deallocate(void* memory, std::size_t bytes, std::size_t alignment) {
        held_ -= bytes;
        ::operator delete (memory, std::align_val_t{alignment});
    }

private:
    std::size_t limit_;
    std::atomic<std::size_t> held_{0};
    std::atomic<std::size_t> peak_{0};
};
