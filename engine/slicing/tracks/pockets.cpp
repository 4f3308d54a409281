#include "slicing/tracks/pockets.hpp"

#include <algorithm>
#include <tuple>

#include "base/sort.hpp"

namespace lamella {

void Pockets::add_layer(std::uint32_t end, std::span<const TrackLink> links) {
    list_closed();
    first_ = static_cast<std::uint32_t>(parents_.size());
    for (std::uint32_t v = first_; v < end; ++v) {
        const TrackVoid& own = voids_[v];
        parents_.push_back(v);
        spaces_.push_back({{.contour = own.contour,
                            .first_layer = layer_,
                            .end_layer = layer_ + 1,
                            .volume_mm3 = own.twice_area.to_double() * own.slab_mm3},
                           own.is_outside || layer_ == 0});
    }
    std::for_each(links.begin(), links.end(), [this](const TrackLink& link) { unite(link); });
    for (const auto& [space, pocket] : closed_) {
        const Space& now = spaces_[root(space)];
        if (now.is_open || now.pocket.end_layer == ended) {
            add_found(pocket, !now.is_open);
        }
    }
    ++layer_;
}

void Pockets::finish() {
    list_closed();
    for (const auto& [space, pocket] : closed_) {
        add_found(pocket, false);
    }
    sort_briefly(found_.begin(), found_.end(), [](const Pocket& a, const Pocket& b) {
        return std::tie(a.end_layer, a.first_layer, a.contour) < std::tie(b.end_layer, b.first_layer, b.contour);
    });
}

/// Those that have voids in the last layer: each once, as they have ended unless they go on.
void Pockets::list_closed() {
    closed_.clear();
    for (std::uint32_t v = first_; v < parents_.size(); ++v) {
        const std::uint32_t r = root(v);
        if (!spaces_[r].is_open && spaces_[r].pocket.end_layer == layer_) {
            closed_.emplace_back(r, spaces_[r].pocket);
            spaces_[r].pocket.end_layer = ended;
        }
    }
}

std::uint32_t Pockets::root(std::uint32_t v) noexcept {
    while (parents_[v] != v) {
        parents_[v] = parents_[parents_[v]];
        v = parents_[v];
    }
    return v;
}

/// The smaller root is that of both.
void Pockets::unite(const TrackLink& link) {
    const auto [a, b] = std::minmax({root(link.lower), root(link.upper)});
    if (a == b) {
        return;
    }
    parents_[b] = a;
    Space& whole = spaces_[a];
    const Space& other = spaces_[b];
    whole.is_open = whole.is_open || other.is_open;
    whole.pocket.volume_mm3 += other.pocket.volume_mm3;
    whole.pocket.end_layer = std::max(whole.pocket.end_layer, other.pocket.end_layer);
}

void Pockets::add_found(const Pocket& pocket, bool is_cavity) {
    Pocket& found = found_.emplace_back(pocket);
    found.end_layer = layer_;
    found.is_cavity = is_cavity;
}

}  // namespace lamella
