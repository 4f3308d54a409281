#include "models/surface.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <string>
#include <utility>

namespace lamella::models {

namespace {

// Maps floats to unsigned integers of the same order.
std::uint32_t ordered_bits(float value) noexcept {
    const auto bits = std::bit_cast<std::uint32_t>(value + 0.0F);  // -0 becomes +0
    return (bits >> 31) != 0 ? ~bits : bits | 0x80000000U;
}

float centre(float a, float b, float c) noexcept {
    return static_cast<float>((static_cast<double>(a) + static_cast<double>(b) + static_cast<double>(c)) / 3);
}

}  // namespace

Emitter::Emitter(const Consumer& consume, std::uint64_t candidates, std::uint64_t splits)
    : consume_(consume), candidates_(candidates), splits_(splits), due_(candidates - candidates / 4) {
    assert(splits <= candidates);
}

void Emitter::add_splittable(const Triangle& triangle) {
    due_ += splits_;
    if (due_ < candidates_ || splits_ == 0) {
        add(triangle);
        return;
    }
    due_ -= candidates_;
    const auto& [a, b, c] = triangle;
    const Vertex g{centre(a.x, b.x, c.x), centre(a.y, b.y, c.y), centre(a.z, b.z, c.z)};
    add({a, b, g});
    add({b, c, g});
    add({c, a, g});
}

bool Emitter::flush() {
    assert(pending_.size() <= std::numeric_limits<std::uint32_t>::max());
    keys_.resize(pending_.size());
    for (std::size_t i = 0; i < pending_.size(); ++i) {
        const auto& [a, b, c] = pending_[i];
        keys_[i] = std::uint64_t{ordered_bits(std::min({a.z, b.z, c.z}))} << 32 | i;
    }
    std::sort(keys_.begin(), keys_.end());
    sorted_.resize(pending_.size());
    for (std::size_t i = 0; i < keys_.size(); ++i) {
        sorted_[i] = pending_[keys_[i] & 0xffffffffU];
    }
    pending_.clear();
    stopped_ = stopped_ || !consume_(sorted_);
    return !stopped_;
}

Error unreachable(const Recipe& recipe, double nearest) {
    std::string message = "a " + std::string(shape_names[static_cast<std::size_t>(recipe.shape)]) + " of " +
                          std::to_string(recipe.triangles) + " triangles and this size cannot be made";
    if (recipe.segments) {
        message += " with " + std::to_string(*recipe.segments) + " segments at this layer height: the nearest tried has " +
                   std::to_string(static_cast<std::uint64_t>(nearest));
    }
    return {ErrorCode::invalid_argument, std::move(message)};
}

}  // namespace lamella::models
