// Stop requests within work that one thread does by itself, such as a plane of a slice: the host is asked by the work done,
// so that small pieces of work cost next to nothing and long ones end soon.
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/parallel.hpp"

namespace lamella {

/// A unit of work is one of the steps that are done for every point or edge: 1 to 10 ns where memory is read in order.
/// Steps that wait for memory count for several.
class StopPace {
public:
    /// From here on the host is asked.
    void follow(const StopCheck& host) noexcept {
        host_ = host;
        left_ = work_between_asks;
    }

    /// After `work` units: throws Stopped where the host wants the call to end.
    void spend(std::size_t work) {
        if (work < left_) {
            left_ -= work;
        } else {
            ask();
        }
    }

    /// Calls body(begin, end) for one stretch of [begin, end) after another; an index costs `work` units.
    template <class Body>
    void in_stretches(std::size_t begin, std::size_t end, std::size_t work, Body body) {
        const std::size_t most = work_between_asks / work;
        while (begin < end) {
            const std::size_t next = begin + std::min(most, end - begin);
            body(begin, next);
            spend(work * (next - begin));
            begin = next;
        }
    }

    /// At once.
    void ask() {
        left_ = work_between_asks;
        if (host_.stop_requested()) {
            throw Stopped();
        }
    }

private:
    static constexpr std::size_t work_between_asks = std::size_t{1} << 17;

    StopCheck host_{};
    std::size_t left_ = work_between_asks;
};

}  // namespace lamella
