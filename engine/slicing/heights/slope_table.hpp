// The least slope among the facets over each step of height.
//
//     steps     0   1   2   3   4   5   6   7
//     facet         [-------------------]           over steps 1 to 5: two ranges of 4 steps cover it
//     level 2       [---------------]
//                       [---------------]
//
// Level j holds ranges of 2^j steps, one from each step on. A facet is written into two of them; when all are, each range
// gives what it holds to its two halves. Minima commute, so that threads may write in any order. Most facets change nothing:
// an entry is read far more often than written. Where all steps of a block of facets have one that is as flat as can be, as
// most have soon in a fine mesh, the block is not read.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/numbers.hpp"
#include "base/system/atomic_word.hpp"
#include "lamella/array.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// From heights in mm to steps above the lowest vertex.
struct StepScale {
    /// What rounding of coordinates may do, in steps: what lies so near is equal.
    static constexpr double slack = 0.01;

    double low_mm;
    double per_mm;

    double of(double mm) const noexcept { return (mm - low_mm) * per_mm; }
};

class SlopeTable {
public:
    /// Slopes of a squared tangent up to `flattest` are one: what is less makes no difference to any height.
    SlopeTable(std::uint32_t steps, float flattest, const Memory* memory);

    static std::uint64_t bytes_for(std::uint64_t steps) noexcept {
        return steps * static_cast<std::uint64_t>(std::bit_width(steps)) * sizeof(std::uint32_t) + steps / 8;
    }

    /// The facets of blocks [begin, end) of a mesh that was measured, whose heights lie within the steps. From any thread.
    void add(const MeshView& mesh, const Placing& placing, const BlockTable& measured, std::size_t begin, std::size_t end,
             const StepScale& scale) noexcept;

    /// All facets have been added.
    void settle() noexcept;
    /// The squared tangent of the least slope over a step, at most `upright`. Precondition: settled.
    float squared_tangent(std::size_t step) const noexcept { return bits_as<float>(entries_[step]); }

    static constexpr float upright = 1e30F;  ///< stands for any steeper slope

private:
    /// Steps [first, end).
    struct Steps {
        std::size_t first;
        std::size_t end;
    };
    Steps between(double low_mm, double high_mm, const StepScale& scale) const noexcept;

    template <class Reader>
    void add_blocks(const Reader& read, std::size_t triangles, const BlockTable& measured, Steps blocks,
                    const StepScale& scale) noexcept;
    void add_facet(Steps over, float squared_tangent) noexcept;

    /// As unsigned words, which floats of no sign compare as.
    void lower(std::size_t at, std::uint32_t bits) noexcept {
        const AtomicWord<std::uint32_t> entry(entries_[at]);
        for (std::uint32_t now = entry.load(); bits < now && !entry.replace(now, bits);) {
        }
    }
    /// Calls use(word, bits) for the words of `open_` that have bits for some of the steps, until it returns true.
    template <class Use>
    bool any_word(Steps steps, Use use) noexcept;

    std::size_t steps_;
    std::size_t levels_;
    float flattest_;
    Array<std::uint32_t> entries_;  // level after level
    Array<std::uint64_t> open_;     // bits of steps over which no facet is as flat as can be yet
};

}  // namespace lamella
