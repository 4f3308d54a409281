// A thread of a call, as what works on it sees it.
#pragma once

#include "base/parallel.hpp"
#include "lamella/context.hpp"

namespace lamella {

/// Where scratch comes from, and when the host is asked whether the call is to end: one for all that a thread does, which
/// holds it by reference. What works on it may throw Stopped wherever it spends.
class Worker : public StopPace {
public:
    /// `memory`: null for operator new.
    explicit Worker(const Memory* memory = nullptr) noexcept : memory_(memory) {}
    /// The host is asked from the start.
    Worker(const Memory* memory, const StopCheck& host) noexcept : memory_(memory) { follow(host); }
    Worker(const Worker&) = delete;  // referred to by what works on it
    Worker& operator=(const Worker&) = delete;

    const Memory* memory() const noexcept { return memory_; }

private:
    const Memory* memory_;
};

}  // namespace lamella
