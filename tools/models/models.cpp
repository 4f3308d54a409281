#include "models/models.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "base/numbers.hpp"
#include "models/numbers.hpp"
#include "models/surface.hpp"

namespace lamella::models {

namespace {

// Maps floats to unsigned integers of the same order.
std::uint32_t ordered_bits(float value) noexcept {
    const auto bits = bits_as<std::uint32_t>(value + 0.0F);  // -0 becomes +0
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

namespace {

Status check(const Recipe& recipe) {
    const auto out_of_range = [](const char* what, const char* range) {
        return Error{ErrorCode::invalid_argument, std::string(what) + ": must lie " + range};
    };
    const auto length_ok = [](double mm) { return mm >= 1e-3 && mm <= 1e6; };
    if (recipe.triangles < fewest_triangles || recipe.triangles > most_triangles) {
        return out_of_range("triangles", "between 100 and 1000000000");
    }
    if (recipe.order == Order::random && recipe.triangles > most_shuffled) {
        return out_of_range("triangles", "between 100 and 100000000 where their order is random");
    }
    if (!length_ok(recipe.height_mm) || (recipe.width_mm && !length_ok(*recipe.width_mm))) {
        return out_of_range(length_ok(recipe.height_mm) ? "width" : "height", "between 0.001 and 1000000 mm");
    }
    if (recipe.segments && !(recipe.layer_height_mm > 0 && recipe.layer_height_mm <= recipe.height_mm)) {
        return out_of_range("layer height", "above 0 and within the height where segments are given");
    }
    if (recipe.segments && *recipe.segments == 0) {
        return out_of_range("segments", "above 0");
    }
    return {};
}

}  // namespace

Plan plan(const Recipe& recipe) {
    if (const Status status = check(recipe); !status) {
        return status.error();
    }
    const bool rings = recipe.shape == Shape::sphere || recipe.shape == Shape::prism;
    return rings ? plan_rings(recipe) : plan_isosurface(recipe);
}

std::vector<Triangle> collect(const Recipe& recipe, const Surface& surface) {
    std::vector<Triangle> all;
    all.reserve(surface.triangles);
    surface.emit([&](std::span<const Triangle> batch) {
        all.insert(all.end(), batch.begin(), batch.end());
        return true;
    });
    assert(all.size() == surface.triangles);
    if (recipe.order == Order::random) {
        Random random(recipe.seed);
        for (auto left = static_cast<std::uint32_t>(all.size()); left > 1; --left) {
            std::swap(all[left - 1], all[random.below(left)]);
        }
    }
    return all;
}

std::vector<float> make_soup(const Recipe& recipe) {
    Plan planned = plan(recipe);
    if (!planned) {
        return {};
    }
    const std::vector<Triangle> triangles = collect(recipe, *planned);
    std::vector<float> soup(triangles.size() * 9);
    if (!triangles.empty()) {
        std::memcpy(soup.data(), triangles.data(), soup.size() * sizeof(float));
    }
    return soup;
}

}  // namespace lamella::models
