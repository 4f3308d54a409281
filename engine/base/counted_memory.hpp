// Memory that is counted.
#pragma once

#include <atomic>
#include <cstddef>

#include "lamella/array.hpp"
#include "lamella/context.hpp"

namespace lamella {

/// The host's memory, or operator new's, with a count of what is taken of it.
class CountedMemory {
public:
    /// `host`: null for operator new.
    explicit CountedMemory(const Memory* host) noexcept : host_(host) {}
    CountedMemory(const CountedMemory&) = delete;  // referred to by what takes memory
    CountedMemory& operator=(const CountedMemory&) = delete;

    const Memory* host() const noexcept { return host_; }
    const Memory* memory() const noexcept { return &counting_; }
    /// Taken and not given back.
    std::size_t bytes() const noexcept { return bytes_.load(std::memory_order_relaxed); }

    /// For memory_of(). Arrays ask for no other alignment than what the host is asked for. Throws std::bad_alloc.
    void* allocate(std::size_t bytes, std::size_t /*alignment*/) {
        void* const block = detail::take_memory(host_, bytes);
        bytes_.fetch_add(bytes, std::memory_order_relaxed);
        return block;
    }
    void deallocate(void* block, std::size_t bytes, std::size_t /*alignment*/) noexcept {
        bytes_.fetch_sub(bytes, std::memory_order_relaxed);
        detail::give_memory(host_, block, bytes);
    }

private:
    const Memory* host_;
    std::atomic<std::size_t> bytes_ = 0;
    const Memory counting_ = memory_of(*this);
};

}  // namespace lamella
