// Memory that counts what is asked for and held, and that can run out.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>

#include "lamella/context.hpp"

class CountingMemory : public lamella::Memory {
public:
    /// An allocation that would exceed `limit` bytes in total fails, and so does number `fails_at`, from 1, with every later
    /// one: exhausted memory stays exhausted.
    explicit CountingMemory(std::size_t limit = ~std::size_t{0}, std::uint64_t fails_at = ~std::uint64_t{0})
        : Memory(lamella::memory_of(*this)), limit_(limit), fails_at_(fails_at) {}
    std::uint64_t asked() const { return asked_; }
    std::size_t peak() const { return peak_; }
    std::size_t held() const { return held_; }

    void* allocate(std::size_t bytes, std::size_t alignment) {
        const std::size_t held = held_ += bytes;
        if (++asked_ >= fails_at_ || held > limit_) {
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
    std::uint64_t fails_at_;
    std::atomic<std::uint64_t> asked_{0};
    std::atomic<std::size_t> held_{0};
    std::atomic<std::size_t> peak_{0};
};
