#include "slicing/nesting/starts.hpp"

#include <bit>

namespace lamella::nesting {

void StartLine::assign(std::span<const SortKey> by_start) {
    const std::size_t count = by_start.size();
    if (xs_.size() < count + lanes) {
        xs_.resize(count + count / 2 + lanes);
        ys_.resize(count + count / 2 + lanes);
    }
    for (std::size_t i = 0; i < count; ++i) {
        xs_[i] = x_of(by_start[i].key);
        ys_[i] = y_of(by_start[i].key);
    }
    for (std::size_t i = count; i < count + lanes; ++i) {
        xs_[i] = std::numeric_limits<std::int32_t>::max();
        ys_[i] = nowhere;
    }
}

std::uint32_t StartLine::first_right_of(std::uint32_t of, std::uint32_t from) const noexcept {
    std::uint32_t first = from;
    while (xs_[first] == xs_[of]) {
        ++first;
    }
    return first;
}

StartLine::Window StartLine::window(std::uint32_t begin, std::int32_t max_x, std::int32_t min_y,
                                    std::int32_t max_y) const noexcept {
    unsigned occupied = 0;
    for (std::uint32_t first = begin;; first += lanes) {
        const unsigned left = between(xs_.data() + first, nowhere, max_x);
        occupied |= left & between(ys_.data() + first, min_y, max_y);
        if (left != 0xFFFFU) {
            return {begin, first + static_cast<std::uint32_t>(std::countr_one(left)), occupied != 0};
        }
    }
}

void StartLine::find(const Window& window, std::int32_t min_y, std::int32_t max_y, Vector<std::uint32_t>& found) const {
    for (std::uint32_t first = window.begin; first < window.end; first += lanes) {
        unsigned inside = between(ys_.data() + first, min_y, max_y);
        if (window.end - first < lanes) {
            inside &= (1U << (window.end - first)) - 1;
        }
        for (; inside != 0; inside &= inside - 1) {
            found.push_back(first + static_cast<std::uint32_t>(std::countr_zero(inside)));
        }
    }
}

}  // namespace lamella::nesting
