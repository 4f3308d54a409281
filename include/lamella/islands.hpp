// Outers with their holes: what a host calls an ExPolygon or a polygon with holes.
//
//     for (const lamella::Layer& layer : result.layers) {
//         for (const lamella::Island island : lamella::islands_of(result.contours_of(layer))) {
//             std::printf("%u points, %zu holes\n", island.outer->point_count, island.holes.size());
//         }
//     }
//
// A view: nothing is allocated. It rests on the order of contours, in which each outer is followed by its holes. Contours of
// role flat and open belong to no island.
#pragma once

#include <cstddef>
#include <iterator>
#include <span>

#include "lamella/result.hpp"

namespace lamella {

/// An outer contour and what is cut out of it.
struct Island {
    const Contour* outer = nullptr;
    std::span<const Contour> holes;
};

/// The islands of a layer: a forward range. Advancing is O(holes), or O(n) over flat and open contours.
class Islands {
public:
    class Iterator {
    public:
        using value_type = Island;
        using difference_type = std::ptrdiff_t;
        using iterator_category = std::input_iterator_tag;  // since an Island is made, not referred to
        using iterator_concept = std::forward_iterator_tag;

        Iterator() = default;
        Iterator(const Contour* at, const Contour* end) noexcept : at_(at), end_(end) { find(); }

        Island operator*() const noexcept { return {at_, {at_ + 1, next_}}; }
        Iterator& operator++() noexcept {
            at_ = next_;
            find();
            return *this;
        }
        Iterator operator++(int) noexcept {
            const Iterator before = *this;
            ++*this;
            return before;
        }
        friend bool operator==(const Iterator& a, const Iterator& b) noexcept { return a.at_ == b.at_; }

    private:
        void find() noexcept {
            while (at_ != end_ && at_->role != Role::outer) {
                ++at_;
            }
            next_ = at_ == end_ ? end_ : at_ + 1;
            while (next_ != end_ && next_->role == Role::hole) {
                ++next_;
            }
        }

        const Contour* at_ = nullptr;    // an outer, or the end
        const Contour* next_ = nullptr;  // past its holes
        const Contour* end_ = nullptr;
    };

    explicit Islands(std::span<const Contour> contours) noexcept : contours_(contours) {}
    Iterator begin() const noexcept { return {contours_.data(), contours_.data() + contours_.size()}; }
    Iterator end() const noexcept {
        const Contour* const past = contours_.data() + contours_.size();
        return {past, past};
    }

private:
    std::span<const Contour> contours_;
};

/// Of the contours of one layer: SliceResult::contours_of(), LayerView::contours or LayerContours::contours.
inline Islands islands_of(std::span<const Contour> contours) noexcept {
    return Islands(contours);
}

}  // namespace lamella
