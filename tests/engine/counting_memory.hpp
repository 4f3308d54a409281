// A memory resource that knows how much was ever taken at once.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory_resource>
#include <new>

class CountingMemory final : public std::pmr::memory_resource {
public:
    /// Takes beyond `limit` bytes at once fail.
    explicit CountingMemory(std::size_t limit = ~std::size_t{0}) : limit_(limit) {}
    std::size_t peak() const { return peak_; }
    std::size_t held() const { return held_; }

private:
    void* do_allocate(std::size_t bytes, std::size_t alignment) override {
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
    void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
        held_ -= bytes;
        ::operator delete (memory, std::align_val_t{alignment});
    }
    bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }

    std::size_t limit_;
    std::atomic<std::size_t> held_{0};
    std::atomic<std::size_t> peak_{0};
};
