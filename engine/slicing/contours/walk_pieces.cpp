// The walk of a plane where most links changed since the last one.
//
// Each link must be read before the next one is known, so a walk along one contour waits for memory at every slot. Four
// pieces of contours are walked at once instead. They begin at slots of the last plane's order, their heads, and end before
// the next head:
//
//     contour      ... -> a b c d e f g h i j k l -> a ...
//     heads               ^       ^       ^
//     lane 1              a b c d
//     lane 2                      e f g h
//     lane 3                              i j k l           joined: a b c d e f g h i j k l
//
// Contours that no head lies on begin at this plane, and are walked link by link.
#include <algorithm>

#include "slicing/contours/link_graph.hpp"

namespace lamella {

namespace {

constexpr std::uint32_t slots_per_piece = 128;  // of long contours, so that all four lanes have work to the end
constexpr std::uint32_t head_search = 16;       // slots of the old order searched for one that is in use

}  // namespace

/// Chooses the heads. Precondition: contours() and order() are the last plane's, and no slot has an open end.
void LinkGraph::cut_pieces() {
    pieces_.clear();
    is_head_.assign(slots_.slot_end() / 64 + 1, 0);
    for (const WalkedContour& contour : contours_) {
        const std::uint32_t end = contour.begin + contour.count + 1;
        for (std::uint32_t begin = contour.begin + 1; begin < end; begin += slots_per_piece) {
            add_piece(begin, std::min(end, begin + head_search));
        }
    }
}

/// Begins at a slot of old positions [begin, end), if one is in use.
void LinkGraph::add_piece(std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t position = begin; position < end; ++position) {
        const Slot head = order_[position];
        if (!slots_.is_free(head)) {
            position_[head] = position;  // a slot freed and made again has none
            is_head_[head >> 6] |= std::uint64_t{1} << (head & 63);
            pieces_.push_back({head, position, nullptr, 0, no_slot});
            return;
        }
    }
}

void LinkGraph::walk_pieces() {
    if (!pieces_.empty()) {
        walk_four_at_once();
        join_pieces();
    }
}

/// Each of four lanes writes one piece after the other to its own stretch of `lanes_`.
void LinkGraph::walk_four_at_once() {
    struct Lane {
        Slot next;
        Slot* out;
        Piece* piece;
    };
    const std::size_t room = slots_.live() + run_padding;
    grow_exactly(lanes_, 4 * room, worker_);
    const Port* const ports = slots_.ports();
    const std::uint64_t* const is_head = is_head_.data();
    Piece* waiting = pieces_.data();
    Piece* const end = waiting + pieces_.size();
    const auto begin = [&](Lane& lane) {
        lane.piece = waiting != end ? waiting++ : nullptr;
        if (lane.piece == nullptr) {
            return false;
        }
        worker_.spend(slot_work * slots_per_piece);
        lane.piece->slots = lane.out;
        lane.next = lane.piece->head;
        return true;
    };
    const auto step = [&](Lane& lane) {
        *lane.out++ = lane.next;
        lane.next = slot_of(ports[port_of(lane.next, source_port)].across);
        if ((is_head[lane.next >> 6] >> (lane.next & 63) & 1) == 0) {
            return true;
        }
        lane.piece->count = static_cast<std::uint32_t>(lane.out - lane.piece->slots);
        lane.piece->next_head = lane.next;
        return false;
    };
    const auto advance = [&](Lane& lane) { return step(lane) || begin(lane); };
    Slot* const out = lanes_.data();
    Lane a{0, out, nullptr};
    Lane b{0, out + room, nullptr};
    Lane c{0, out + 2 * room, nullptr};
    Lane d{0, out + 3 * room, nullptr};
    if (begin(a) && begin(b) && begin(c) && begin(d)) {
        while (advance(a) && advance(b) && advance(c) && advance(d)) {
        }
    }
    const auto finish = [&](Lane& lane) {
        while (lane.piece != nullptr && step(lane)) {
        }
    };
    finish(a);  // not in a loop over addresses: lanes stay in registers
    finish(b);
    finish(c);
    finish(d);
    for (Piece& piece : pieces_) {  // before slots are numbered anew
        piece.next = piece_at(position_[piece.next_head]);
    }
}

/// The piece whose head had the position: heads ascend by it.
std::uint32_t LinkGraph::piece_at(std::uint32_t position) const {
    const auto found = std::partition_point(pieces_.begin(), pieces_.end(),
                                            [position](const Piece& piece) { return piece.position < position; });
    return static_cast<std::uint32_t>(found - pieces_.begin());
}

/// Contours in the order of their first heads.
void LinkGraph::join_pieces() {
    Slot* const out = order_next_.data() + 1;
    for (Piece& first : pieces_) {
        if (first.count == 0) {
            continue;
        }
        const std::uint32_t begin = filled_;
        Piece* piece = &first;
        do {
            copy_run(piece->slots, piece->count, out + filled_);
            number_run(piece->slots, piece->count, filled_ + 1, position_.data());
            filled_ += piece->count;
            worker_.spend(slot_work * piece->count);
            piece->count = 0;
            piece = &pieces_[piece->next];
        } while (piece != &first);
        add_contour(begin, true, false);
    }
}

}  // namespace lamella
