// How many triangles planes begin and end to cut: from these numbers ranges of layers are chosen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// A difference array over k planes: a triangle that planes first to last - 1 cut is counted at both.
class PlaneCounts {
public:
    explicit PlaneCounts(std::size_t planes = 0) : starting_(planes + 1), ended_(planes + 1) {}

    void add(PlaneIndex first, PlaneIndex last) noexcept {
        ++starting_[first];
        ++ended_[last];
    }
    /// Moves the counts of `other` here.
    void take(PlaneCounts& other) noexcept {
        for (std::size_t i = 0; i < starting_.size(); ++i) {
            starting_[i] += std::exchange(other.starting_[i], 0U);
            ended_[i] += std::exchange(other.ended_[i], 0U);
        }
    }

    std::size_t planes() const noexcept { return starting_.size() - 1; }
    /// Triangles that the plane is the first to cut.
    std::uint32_t starting(std::size_t plane) const noexcept { return starting_[plane]; }
    /// Triangles that the plane below it is the last to cut.
    std::uint32_t ended(std::size_t plane) const noexcept { return ended_[plane]; }
    /// Triangles that the plane cuts, and the one below it too. O(plane).
    std::uint64_t reaching_into(std::size_t plane) const noexcept {
        std::uint64_t reaching = 0;
        for (std::size_t p = 0; p < plane; ++p) {
            reaching += starting_[p];
            reaching -= ended_[p];
        }
        return reaching - ended_[plane];
    }

private:
    std::vector<std::uint32_t> starting_;
    std::vector<std::uint32_t> ended_;
};

}  // namespace lamella
