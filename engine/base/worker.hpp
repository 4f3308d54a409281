// A thread of a call, as what works on it sees it.
#pragma once

#include "base/dispatch.hpp"
#include "base/parallel.hpp"
#include "lamella/context.hpp"

namespace lamella {

/// Where scratch comes from, which forms of kernels run, and when the host is asked whether the call is to end: one for all
/// that a thread does, which holds it by reference. What works on it may throw Stopped wherever it spends.
class Worker : public StopPace {
public:
    /// `memory`: null for operator new.
    explicit Worker(const Memory* memory = nullptr, InstructionSet instructions = instruction_set()) noexcept
        : memory_(memory), instructions_(instructions) {}
    /// The host is asked from the start.
    Worker(const Memory* memory, const StopCheck& host, InstructionSet instructions = instruction_set()) noexcept
        : Worker(memory, instructions) {
        follow(host);
    }
    Worker(const Worker&) = delete;  // referred to by what works on it
    Worker& operator=(const Worker&) = delete;

    const Memory* memory() const noexcept { return memory_; }
    InstructionSet instructions() const noexcept { return instructions_; }

private:
    const Memory* memory_;
    InstructionSet instructions_;
};

}  // namespace lamella
