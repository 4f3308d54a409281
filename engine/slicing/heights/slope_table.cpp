#include "slicing/heights/slope_table.hpp"

#include <algorithm>
#include <cstring>

namespace lamella {

namespace {

constexpr std::size_t word_bits = 64;

/// A triangle of floats that nothing moves, as PlacedReader reads others.
class FloatFacets {
public:
    struct Triangle {
        float v[9];
    };

    explicit FloatFacets(const MeshView& mesh) noexcept : mesh_(mesh) {
        mesh_.vertex_stride = mesh.vertex_step();  // looked up once
        mesh_.index_stride = mesh.index_step();
    }

    Triangle operator()(std::size_t t) const noexcept {
        constexpr std::size_t bytes = 3 * sizeof(float);
        Triangle raw;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::byte* const at =
                mesh_.indices != nullptr ? mesh_.vertex_at(mesh_.vertex_of(t, corner)) : mesh_.vertex_at(t) + corner * bytes;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                std::memcpy(raw.v + 3 * corner + axis, at + axis * sizeof(float), sizeof(float));
            }
        }
        return raw;
    }

private:
    MeshView mesh_;
};

/// The squared tangent of a facet's slope, at most `upright`; 0 where it is flat or has no area. In the numbers of the
/// corners: differences of neighbours are nearly exact, and products round off less than the corners were rounded by.
template <class Real>
Real squared_tangent_of(const Real (&v)[9]) noexcept {
    const Real ab[3] = {v[3] - v[0], v[4] - v[1], v[5] - v[2]};
    const Real ac[3] = {v[6] - v[0], v[7] - v[1], v[8] - v[2]};
    const Real x = ab[1] * ac[2] - ab[2] * ac[1];
    const Real y = ab[2] * ac[0] - ab[0] * ac[2];
    const Real z = ab[0] * ac[1] - ab[1] * ac[0];
    const Real upright = x * x + y * y;
    return upright > 0 ? std::min<Real>(upright / (z * z), SlopeTable::upright) : 0;
}

}  // namespace

SlopeTable::SlopeTable(std::uint32_t steps, float flattest, const Memory* memory)
    : steps_(steps),
      levels_(static_cast<std::size_t>(std::bit_width(steps))),
      flattest_(flattest),
      entries_(memory),
      open_(memory) {
    entries_.resize_discarding(steps_ * levels_);
    std::fill(entries_.begin(), entries_.end(), bits_as<std::uint32_t>(upright));
    open_.resize_discarding(steps_ / word_bits + 1);
    std::fill(open_.begin(), open_.end(), ~std::uint64_t{0});
}

SlopeTable::Steps SlopeTable::between(double low_mm, double high_mm, const StepScale& scale) const noexcept {
    const std::size_t first = std::min(static_cast<std::size_t>(scale.of(low_mm) + StepScale::slack), steps_ - 1);
    const auto rounded_up = static_cast<std::size_t>(scale.of(high_mm) + (1 - StepScale::slack));
    return {first, std::clamp(rounded_up, first + 1, steps_)};
}

template <class Use>
bool SlopeTable::any_word(Steps steps, Use use) noexcept {
    for (std::size_t at = steps.first; at < steps.end;) {
        const std::size_t end = std::min(steps.end, (at / word_bits + 1) * word_bits);
        const std::uint64_t bits = (~std::uint64_t{0} >> (word_bits - (end - at))) << (at % word_bits);
        if (use(AtomicWord<std::uint64_t>(open_[at / word_bits]), bits)) {
            return true;
        }
        at = end;
    }
    return false;
}

void SlopeTable::add(const MeshView& mesh, const Placing& placing, const BlockTable& measured, std::size_t begin,
                     std::size_t end, const StepScale& scale) noexcept {
    if (mesh.vertex_type == Number::f32 && placing.transform.is_identity()) {
        add_blocks(FloatFacets(mesh), mesh.triangle_count, measured, {begin, end}, scale);
    } else {
        add_blocks(PlacedReader(mesh, placing), mesh.triangle_count, measured, {begin, end}, scale);
    }
}

template <class Reader>
void SlopeTable::add_blocks(const Reader& read, std::size_t triangles, const BlockTable& measured, Steps blocks,
                            const StepScale& scale) noexcept {
    const auto is_open = [](AtomicWord<std::uint64_t> word, std::uint64_t bits) { return (word.load() & bits) != 0; };
    for (std::size_t b = blocks.first; b < blocks.end; ++b) {
        const TriangleBlock& block = measured.blocks[b];
        if (!any_word(between(block.low_mm, block.high_mm, scale), is_open)) {
            continue;
        }
        const std::size_t end = std::min(triangles, (b + 1) * block_triangles);
        for (std::size_t t = b * block_triangles; t < end; ++t) {
            const auto raw = read(t);
            const auto& v = raw.v;
            if (const auto squared_tangent = squared_tangent_of(v); squared_tangent > 0) {
                const auto low = static_cast<double>(std::min({v[2], v[5], v[8]}));
                const auto high = static_cast<double>(std::max({v[2], v[5], v[8]}));
                add_facet(between(low, high, scale), static_cast<float>(squared_tangent));
            }
        }
    }
}

void SlopeTable::add_facet(Steps over, float squared_tangent) noexcept {
    if (squared_tangent <= flattest_) {
        any_word(over, [](AtomicWord<std::uint64_t> word, std::uint64_t bits) {
            word.keep(~bits);
            return false;
        });
        squared_tangent = flattest_;
    }
    const auto bits = bits_as<std::uint32_t>(squared_tangent);
    const std::size_t half = std::bit_floor(over.end - over.first);  // or more: two of these cover all
    const std::size_t row = static_cast<std::size_t>(std::countr_zero(half)) * steps_;
    lower(row + over.first, bits);
    lower(row + over.end - half, bits);
}

void SlopeTable::settle() noexcept {
    for (std::size_t level = levels_ - 1; level > 0; --level) {
        const std::size_t half = std::size_t{1} << (level - 1);
        const std::uint32_t* const from = entries_.data() + level * steps_;
        std::uint32_t* const to = entries_.data() + (level - 1) * steps_;
        for (std::size_t i = 0; i + 2 * half <= steps_; ++i) {
            to[i] = std::min(to[i], from[i]);
            to[i + half] = std::min(to[i + half], from[i]);
        }
    }
}

}  // namespace lamella
