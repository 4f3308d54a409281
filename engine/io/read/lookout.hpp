// Stop requests within loops of one thread.
#pragma once

#include <cstdint>

#include "base/parallel.hpp"

namespace lamella {

/// Looks for a stop request, which throws, once in a few thousand steps. Steps take well below a microsecond.
class Lookout {
public:
    explicit Lookout(const Parallel& parallel) noexcept : parallel_(parallel) {}

    void pass(std::uint64_t steps = 1) {
        steps_ += steps;
        if (steps_ >= often) {
            steps_ = 0;
            parallel_.stop_if_asked();
        }
    }

private:
    static constexpr std::uint64_t often = 4096;

    const Parallel& parallel_;
    std::uint64_t steps_ = 0;
};

}  // namespace lamella
