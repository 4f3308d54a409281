// Stage 6: the walk along the links of a plane where most of them changed; see link_walk.cpp.
//
// Each link must be read before the next one is known, so that a walk along one contour only waits. Four pieces of contours
// are walked at once instead. They begin at slots of the last plane's order, their heads; the link that leads to a head is
// replaced by a mark, which is what ends the piece before it:
//
//     heads              A         B         C
//     contour     ... -> a b c d | e f g h | i j k l | -> a ...          | mark instead of a link
//     walked           1 a b c d
//                      2           e f g h
//                      3                     i j k l                     then put together: a b c d e f g h i j k l
//
// What no head leads to, contours that begin at this plane, is left to the walk link by link.
#include <algorithm>

#include "slicing/contours/copy_run.hpp"
#include "slicing/contours/link_graph.hpp"

namespace lamella {

namespace {

constexpr std::uint32_t slots_per_piece = 128;  // of long contours, so that all four find work to the end
constexpr std::uint32_t head_search = 16;       // slots of the old order looked at for one that is in use

}  // namespace

/// Precondition: the last plane's order is known, no slot has an open end, and marks cannot be taken for links.
void LinkGraph::walk_pieces() {
    pieces_.clear();
    for (const WalkedContour& contour : old_contours_) {
        const std::uint32_t end = contour.begin + contour.count + 1;
        for (std::uint32_t begin = contour.begin + 1; begin < end; begin += slots_per_piece) {
            add_piece(begin, std::min(end, begin + head_search));
        }
    }
    if (pieces_.empty()) {
        return;
    }
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
        links_[pieces_[p].cut] = first_mark + static_cast<PortRef>(p);
    }
    walk_four_at_once();
    for (const Piece& piece : pieces_) {
        links_[piece.cut] = 2 * piece.head + target_port;
    }
    join_pieces();
}

/// Begins at a slot of old positions [begin, end), if one is in use.
void LinkGraph::add_piece(std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t position = begin; position < end; ++position) {
        const Slot head = order_[position];
        if (!is_free(head)) {
            pieces_.push_back({head, links_[2 * head + target_port], nullptr, 0, 0});
            return;
        }
    }
}

/// Each of four lanes writes one piece after the other to its own stretch of `lanes_`.
void LinkGraph::walk_four_at_once() {
    struct Lane {
        PortRef next;
        Slot* out;
        Piece* piece;
    };
    const std::size_t room = live() + run_padding;
    if (lanes_.size() < 4 * room) {
        lanes_.resize(4 * room);
    }
    const PortRef* const links = links_.data();
    Piece* waiting = pieces_.data();
    Piece* const end = waiting + pieces_.size();
    const auto begin = [&](Lane& lane) {
        lane.piece = waiting != end ? waiting++ : nullptr;
        if (lane.piece == nullptr) {
            return false;
        }
        lane.piece->slots = lane.out;
        lane.next = 2 * lane.piece->head;
        return true;
    };
    const auto step = [&](Lane& lane) {
        *lane.out++ = lane.next >> 1;
        lane.next = links[lane.next | source_port];
        if (lane.next < first_mark) {
            return true;
        }
        lane.piece->count = static_cast<std::uint32_t>(lane.out - lane.piece->slots);
        lane.piece->next = lane.next - first_mark;
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
    for (Lane* lane : {&a, &b, &c, &d}) {
        while (lane->piece != nullptr && step(*lane)) {
        }
    }
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
            piece->count = 0;
            piece = &pieces_[piece->next];
        } while (piece != &first);
        add_contour(begin, true, false);
    }
}

}  // namespace lamella
