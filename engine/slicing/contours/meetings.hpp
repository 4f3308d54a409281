// Edges where more than two ends meet, or two of one orientation: which segment goes on as which, by pairing.hpp.
#pragma once

#include <span>

#include "base/function_ref.hpp"
#include "base/vector.hpp"
#include "slicing/contours/pairing.hpp"
#include "slicing/contours/slot_table.hpp"

namespace lamella {

class Meetings {
public:
    explicit Meetings(const Memory* memory) : ends_(memory), pairing_(memory) {}

    /// Sorts the ends that meet at a slot counter-clockwise round its edge.
    using Order = FunctionRef<void(Slot, std::span<MeetingEnd>)>;
    /// Called with (to, from) when a slot is made for the edge of another.
    using Copied = FunctionRef<void(Slot, Slot)>;

    /// Pairs what meets at the fresh slots, marks open ends, corrects `links` where it gives an end another slot; true if
    /// there is such an end. Precondition: end_attaching().
    bool settle(SlotTable& slots, std::span<Link> links, Order order, Copied copied);

private:
    void settle_irregular(SlotTable& slots, std::span<Link> links, Order order, Copied copied);
    void seat_pairs(SlotTable& slots, Slot slot, std::span<Link> links, Copied copied) const;

    Vector<MeetingEnd> ends_;  // that meet at one slot
    Pairing pairing_;
};

}  // namespace lamella
