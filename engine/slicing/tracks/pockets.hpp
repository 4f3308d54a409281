// Cavities and cups, from voids of each layer and their links.
#pragma once

#include <span>

#include "base/numbers.hpp"
#include "base/vector.hpp"
#include "lamella/tracks.hpp"

namespace lamella {

/// A void of a layer.
struct TrackVoid {
    std::uint64_t contour = 0;  ///< its hole
    Integer128 twice_area;      ///< square grid units
    double slab_mm3 = 0;        ///< of half a square unit within its slab
    bool is_outside = false;
};

/// Voids follow one another by layer. Throws std::bad_alloc.
class Pockets {
public:
    Pockets(std::span<const TrackVoid> voids, const Memory* memory)
        : voids_(voids), parents_(memory), spaces_(memory), closed_(memory), found_(memory) {}

    /// The next layer: the voids up to `end`, and links to them from those of the layer before.
    void add_layer(std::uint32_t end, std::span<const TrackLink> links);
    /// No layer comes after.
    void finish();
    Vector<Pocket>& found() noexcept { return found_; }

private:
    /// Voids that hang together up to this layer.
    struct Space {
        Pocket pocket;  // its end_layer comes after the last one with a void
        bool is_open = false;
    };

    static constexpr std::uint64_t ended = 0;

    void list_closed();
    std::uint32_t root(std::uint32_t v) noexcept;
    void unite(const TrackLink& link);
    void add_found(const Pocket& pocket, bool is_cavity);

    std::span<const TrackVoid> voids_;
    Vector<std::uint32_t> parents_;                    // of each void so far
    Vector<Space> spaces_;                             // of each root
    std::uint64_t layer_ = 0;                          // so many have been added
    std::uint32_t first_ = 0;                          // of the voids of the last layer
    Vector<std::pair<std::uint32_t, Pocket>> closed_;  // before a layer is added: roots, and what they are
    Vector<Pocket> found_;
};

}  // namespace lamella
