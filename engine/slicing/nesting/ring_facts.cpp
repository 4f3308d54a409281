#include "slicing/nesting/ring_facts.hpp"

namespace lamella {

RingFacts examine_ring(const Point* ring, std::size_t count) noexcept {
    return facts_of(count, [ring](std::size_t i) { return ring[i]; });
}

RingFacts examine_ring(const Point* ring, std::size_t count, FunctionRef<void()> pause) {
    constexpr std::size_t points_between_pauses = std::size_t{1} << 18;
    return facts_of(count, [ring, pause](std::size_t i) {
        if (i % points_between_pauses == 0) {
            pause();
        }
        return ring[i];
    });
}

}  // namespace lamella
