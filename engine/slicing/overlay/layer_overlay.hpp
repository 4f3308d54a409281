// One layer of the answer, from those of all sets.
//
//     sets      each set's contours in the layers that count here; where they are grown first, or there are too many for
//               the winding number, the region that they bound
//     fill      one arrangement of all. A set has bits of the winding number to itself: one for a region, which rises by it
//               inside; for other contours as many as their own winding number may need, with its sign
//     labels    a region for each label, and the steps after it; then its contours' place in the layer
//
//     set 0   .-------.             winding numbers:  1  inside set 0 only
//             |   .---+---.                           2  inside set 1 only
//             | 1 | 3 | 2 |                           3  inside both
//             '---+---'   |
//                 '-------'  set 1
//
// With regions alone the winding number is the membership, since a region winds once around what is in it, and not around
// what is not.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/overlay.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/overlay/set_reader.hpp"
#include "slicing/regions/fill.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

/// Layer after layer; scratch is kept. One per thread.
class LayerOverlay {
public:
    explicit LayerOverlay(Worker& worker) noexcept : worker_(worker) {}

    /// Appends layer `n` of the answer to `out`, and returns its highest label. `after` must stay. Throws std::bad_alloc,
    /// and Refused where a label is out of range.
    std::uint32_t run(std::span<const LayerSet> sets, const Rule& rule, const LayerRules& after, std::uint64_t n,
                      BandOutput& out);

private:
    /// A contour of a set's region.
    struct Ring {
        Path path;
        std::int64_t weight;
    };

    /// A set's share of winding numbers.
    struct Field {
        int bits = 1;
        FillRule rule = FillRule::contours;  ///< by which its winding number is filled; contours: of a region, 0 or 1
        std::span<const Path> contours{};    ///< of no region
        bool is_region() const noexcept { return rule == FillRule::contours; }
    };

    void list_fields(std::span<const LayerSet> sets, std::uint64_t n);
    void add_sets(std::span<const LayerSet> sets, std::uint64_t n);
    void sort_rings();
    void find_labels(const Rule& rule, std::span<const std::int64_t> windings, std::uint64_t n);
    std::uint64_t membership_of(std::int64_t winding, std::uint64_t n) const;

    Worker& worker_;
    Nester nester_{worker_};
    Fill fill_{worker_};
    LayerBuilder layers_{worker_};
    std::vector<std::unique_ptr<SetReader>> readers_;   // by set
    Vector<Field> fields_{worker_.memory()};            // by set
    Vector<Ring> rings_{worker_.memory()};              // of all sets, by start
    Vector<Path> paths_{worker_.memory()};              // of rings_
    Vector<std::int64_t> weights_{worker_.memory()};    // of rings_
    Vector<std::uint32_t> labels_{worker_.memory()};    // that occur, ascending
    Vector<std::uint32_t> label_of_{worker_.memory()};  // of each winding number
};

}  // namespace lamella
