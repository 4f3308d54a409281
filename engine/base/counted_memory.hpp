// The host's memory, or operator new's, with a count of what is taken of it.
#pragma once

#include <atomic>
#include <cstddef>

#include "lamella/memory.hpp"

namespace lamella {

class CountedMemory {
public:
    /// `host`: null for operator new.
    explicit CountedMemory(const Memory* host) noexcept;
    CountedMemory(const CountedMemory&) = delete;  // what takes memory refers to it
    CountedMemory& operator=(const CountedMemory&) = delete;

    const Memory* host() const noexcept { return host_; }
    const Memory* memory() const noexcept { return &counting_; }
    /// Taken and not given back.
    std::size_t bytes() const noexcept { return bytes_.load(std::memory_order_relaxed); }

private:
    const Memory* host_;
    Memory counting_;
    std::atomic<std::size_t> bytes_ = 0;
};

}  // namespace lamella
