// Where the segments of a band come from. What a port holds changes only when its link is written, as the links do: the
// origin of a segment that stays from plane to plane is never computed again.
#include <algorithm>

#include "slicing/buckets/crossed_triangle.hpp"
#include "slicing/sweep/band_sweep.hpp"

namespace lamella {

namespace {

constexpr std::size_t origin_work = 8;  ///< as StopPace counts it

/// The triangle leaves its lower short edge for the third one, whose number is what the other two leave of 0 + 1 + 2.
PointOrigin above_middle(const CrossedTriangle& t, PointOrigin below) noexcept {
    const auto upper_short = static_cast<std::uint8_t>(3 - below.edge - below.end_edge);
    (t.long_edge_is_source() ? below.end_edge : below.edge) = upper_short;
    return below;
}

}  // namespace

/// Writes the origins of the plane's links to both ports of each.
void BandSweep::put_origins(PlaneIndex plane) {
    grow_exactly(origins_, graph_.capacity(), worker_);
    const auto put = [this](const Link& link, const PointOrigin& origin) {
        for (const PortRef ref : link.ends) {
            origins_[slot_of(ref)].by_port[ref & 1] = origin;
        }
    };
    worker_.in_stretches(0, link_count_, origin_work, [&](std::size_t begin, std::size_t end) {
        for (auto link = static_cast<std::uint32_t>(begin); link < end; ++link) {
            put(links_[link], origin_of_link(link, plane));
        }
    });
    for (const Substitute& substitute : substitutes_) {
        put(links_[substitute.link], origin_by(substitute.record, links_[substitute.link]));
    }
    substitutes_.clear();
}

PointOrigin BandSweep::origin_of_link(std::uint32_t link, PlaneIndex plane) const noexcept {
    const std::uint32_t record = record_of(link);
    const CrossedTriangle& t = buckets_->records[record];
    if (link < first_entering_) {
        const PortRef long_end = links_[link].ends[t.long_edge_is_source() ? source_port : target_port];
        return above_middle(t, origins_[slot_of(long_end)].by_port[long_end & 1]);
    }
    return origin_of(t, buckets_->lowest_corners[record], t.middle_plane() <= plane);
}

/// Faces with the same corners and orientation lie side by side in faces_. The one with the smallest index stands
/// for all. They enter together, and keep the origin where they pass their middle vertex.
void BandSweep::note_substitutes() {
    const auto is_same = [](const FaceAtEdge& a, const FaceAtEdge& b) {
        return a.end.is_source == b.end.is_source && a.apex == b.apex;
    };
    for (auto begin = faces_.begin(); begin != faces_.end();) {
        const auto end =
            std::find_if_not(begin, faces_.end(), [&](const FaceAtEdge& face) { return is_same(face, *begin); });
        const auto smallest =
            std::min_element(begin, end, [](const FaceAtEdge& a, const FaceAtEdge& b) { return a.triangle < b.triangle; });
        for (auto face = begin; face != end; ++face) {
            if (face != smallest && face->end.link >= first_entering_) {
                substitutes_.push_back({face->end.link, record_of(smallest->end.link)});
            }
        }
        begin = end;
    }
}

/// The origin of a link by a record with the same corners. They may be ordered by height in another way where two are
/// equally high.
PointOrigin BandSweep::origin_by(std::uint32_t record, const Link& link) const noexcept {
    const CrossedTriangle& t = buckets_->records[record];
    const EdgeNumbers numbers(t, buckets_->lowest_corners[record]);
    const auto number_at = [&](int port) {
        const MeshEdge& edge = graph_.edge(slot_of(link.ends[port]));
        return edge == long_edge(t) ? numbers.long_edge
                                    : (edge == short_edge(t, true) ? numbers.upper_short : numbers.lower_short);
    };
    return {t.triangle, 0, number_at(source_port), number_at(target_port)};
}

}  // namespace lamella
