#include "5_sweep/band_sweep.hpp"

#include <algorithm>
#include <cassert>

#include "base/clock.hpp"

namespace lamella {

namespace {

/// One layer in so many is timed; clocks at every layer would be felt on small ones.
constexpr PlaneIndex timing_stride = 8;

}  // namespace

BandSweep::BandSweep(std::pmr::memory_resource* memory)
    : kernels_(kernels_for_this_cpu()),
      graph_(memory),
      edges_(memory),
      layers_(memory),
      links_(memory),
      link_records_(memory),
      pending_(memory),
      pending_head_(memory),
      active_(memory),
      faces_(memory),
      points_(memory) {}

bool BandSweep::run(const Band& band, std::span<const std::uint32_t> seeds, const Buckets& buckets, const PlaneSet& planes,
                    ContourForm form, const std::stop_token& stop, BandOutput& out) {
    begin(band, buckets);
    for (PlaneIndex plane = band.first; plane < band.last; ++plane) {
        if (stop.stop_requested()) {
            return false;
        }
        const bool timed = plane % timing_stride == 0;
        layers_.timed = timed;
        const std::uint64_t start = timed ? ticks() : 0;
        const auto seeds_here = plane == band.first ? seeds : std::span<const std::uint32_t>{};
        if (form == ContourForm::assembled) {
            begin_plane_afresh(plane);
            gather_active(plane, seeds_here);
        } else {
            take_events(plane, seeds_here);
        }
        link_events(plane);
        graph_.walk();
        const std::uint64_t linked = timed ? ticks() : 0;
        emit(plane, planes, out);
        if (timed) {
            ticks_.sweep += linked - start;
            ticks_.contours += ticks() - linked;
        }
        compact(plane);
    }
    return true;
}

void BandSweep::begin(const Band& band, const Buckets& buckets) {
    band_ = band;
    buckets_ = &buckets;
    // In a closed mesh a plane has as many edges as segments.
    const std::size_t edges = *std::max_element(buckets.segments.begin() + band.first, buckets.segments.begin() + band.last);
    graph_.clear();
    graph_.reserve(edges + 16);
    edges_.clear(band.first, band.last);
    edges_.reserve(edges + 16);
    pending_.clear();
    pending_free_ = no_link;
    pending_head_.assign(band.last - band.first, no_link);
    active_.clear();
}

// --- Events

/// Swept form: edges that end leave, triangles of the plane's list enter, middle vertices are passed.
void BandSweep::take_events(PlaneIndex plane, std::span<const std::uint32_t> seeds) {
    graph_.released(edges_.take_ended(plane, [this](Slot slot) { graph_.release(slot); }));
    const std::uint32_t list_begin = buckets_->list_begin[plane];
    const std::uint32_t list_end = buckets_->list_begin[plane + 1];
    std::uint32_t& head = pending_head_[plane - band_.first];
    link_count_ = 0;
    first_entering_ = 0;
    if (list_begin == list_end && head == no_link && seeds.empty()) {
        return;
    }
    std::size_t middles = 0;
    for (std::uint32_t p = head; p != no_link; p = pending_[p].next) {
        // The triangle was read when it entered, maybe long ago.
        const auto* record = reinterpret_cast<const char*>(&buckets_->records[pending_[p].record]);
        __builtin_prefetch(record);
        __builtin_prefetch(record + sizeof(CrossedTriangle) - 1);
        ++middles;
    }
    const std::size_t entering = seeds.size() + list_end - list_begin;
    graph_.begin_events(2 * entering + middles);
    reserve_links(entering + middles);
    for (std::uint32_t p = std::exchange(head, no_link); p != no_link;) {
        const Pending pending = pending_[p];
        pass_middle(pending);
        pending_[p].next = std::exchange(pending_free_, p);
        p = pending.next;
    }
    first_entering_ = link_count_;
    for (const std::uint32_t record : seeds) {
        enter(record, plane);
    }
    for (std::uint32_t record = list_begin; record < list_end; ++record) {
        enter(record, plane);
    }
}

void BandSweep::reserve_links(std::size_t count) {
    if (links_.size() < count) {
        links_.resize(count);
        link_records_.resize(count);
    }
}

/// Assembled form: the links of the plane before are forgotten ...
void BandSweep::begin_plane_afresh(PlaneIndex plane) {
    graph_.clear();
    edges_.clear(plane, plane + 1);
    pending_head_.assign(band_.last - band_.first, no_link);
    pending_.clear();
    pending_free_ = no_link;
    link_count_ = 0;
    first_entering_ = 0;
}

/// ... and every triangle of the active set (Algorithm 1, steps 7 to 12) enters anew.
void BandSweep::gather_active(PlaneIndex plane, std::span<const std::uint32_t> seeds) {
    active_.insert(active_.end(), seeds.begin(), seeds.end());
    for (std::uint32_t record = buckets_->list_begin[plane]; record < buckets_->list_begin[plane + 1]; ++record) {
        active_.push_back(record);
    }
    std::erase_if(active_, [&](std::uint32_t record) { return buckets_->records[record].last <= plane; });
    graph_.begin_events(2 * active_.size());
    reserve_links(active_.size());
    for (const std::uint32_t record : active_) {
        enter(record, plane);
    }
}

inline Slot BandSweep::edge_slot(const GridVertex& lower, const GridVertex& upper, PlaneIndex end) {
    const Slot slot = graph_.find_or_add(pack_edge(lower, upper));
    edges_.note_end(slot, end);
    return slot;
}

/// Links a triangle's long edge with a short one: the long one is source or target as the triangle says, the short one the
/// other.
inline void BandSweep::link(const CrossedTriangle& t, std::uint32_t record, PortRef long_end, Slot short_edge) {
    const bool from_long = t.long_edge_is_source();
    const PortRef short_end = graph_.attach(short_edge, from_long ? target_port : source_port, link_count_);
    // Selected rather than stored by index: an eight-byte copy of two four-byte stores stalls.
    static_assert(target_port == 0 && source_port == 1);
    links_[link_count_] = {{from_long ? short_end : long_end, from_long ? long_end : short_end}};
    link_records_[link_count_] = record;
    ++link_count_;
}

inline void BandSweep::enter(std::uint32_t record, PlaneIndex plane) {
    const CrossedTriangle& t = buckets_->records[record];
    const bool above_middle = t.middle_plane() <= plane;
    const Slot long_edge = edge_slot(t.lower, t.upper, t.last);
    const Slot short_edge = edge_slot(above_middle ? t.middle : t.lower, above_middle ? t.upper : t.middle,
                                      above_middle ? t.last : t.middle_plane());
    const int long_port = t.long_edge_is_source() ? source_port : target_port;
    link(t, record, graph_.attach(long_edge, long_port, link_count_), short_edge);
}

inline void BandSweep::pass_middle(const Pending& pending) {
    const CrossedTriangle& t = buckets_->records[pending.record];
    link(t, pending.record, pending.long_edge, edge_slot(t.middle, t.upper, t.last));
}

void BandSweep::link_events(PlaneIndex plane) {
    if (link_count_ == 0) {
        return;
    }
    const std::span<Link> links{links_.data(), link_count_};
    for (const Slot slot : graph_.end_attaching()) {
        GridVertex lower;
        GridVertex upper;
        unpack_edge(graph_.key(slot), lower, upper);
        edges_.put(slot, lower, upper);
    }
    graph_.settle(
        links, [this](Slot slot, std::span<MeetingEnd> ends) { sort_meeting(slot, ends); },
        [this](Slot to, Slot from) { edges_.copy(to, from); });
    for (const Link& link : links) {
        graph_.connect(link);
    }
    for (std::size_t i = first_entering_; i < link_count_; ++i) {
        const PlaneIndex middle = buckets_->records[link_records_[i]].middle_plane();
        if (middle > plane && middle < band_.last) {
            expect_middle(link_records_[i], links_[i]);
        }
    }
}

void BandSweep::expect_middle(std::uint32_t record, const Link& link) {
    const CrossedTriangle& t = buckets_->records[record];
    if (t.middle_plane() >= t.last) {
        return;  // no plane lies between the middle vertex and the upper one
    }
    std::uint32_t& head = pending_head_[t.middle_plane() - band_.first];
    const Pending pending{record, link.ends[t.long_edge_is_source() ? source_port : target_port], head};
    if (pending_free_ != no_link) {
        head = pending_free_;
        pending_free_ = pending_[head].next;
        pending_[head] = pending;
    } else {
        head = static_cast<std::uint32_t>(pending_.size());
        pending_.push_back(pending);
    }
}

/// Where more than two faces meet at an edge: the faces of the ends, sorted round it.
void BandSweep::sort_meeting(Slot slot, std::span<MeetingEnd> ends) {
    faces_.clear();
    GridVertex lower;
    GridVertex upper;
    unpack_edge(graph_.key(slot), lower, upper);
    for (const MeetingEnd& end : ends) {
        const CrossedTriangle& t = buckets_->records[link_records_[end.link]];
        const bool has_lowest = t.lower == lower || t.lower == upper;
        const bool has_middle = t.middle == lower || t.middle == upper;
        faces_.push_back({!has_lowest ? t.lower : (has_middle ? t.upper : t.middle), t.triangle, end});
    }
    sort_round_edge(lower, upper, faces_);
    std::transform(faces_.begin(), faces_.end(), ends.begin(), [](const FaceAtEdge& face) { return face.end; });
}

// --- The plane

void BandSweep::emit(PlaneIndex plane, const PlaneSet& planes, BandOutput& out) {
    if (graph_.live() == 0) {
        LayerBuilder::skip(out);
        return;
    }
    if (points_.size() < edges_.capacity()) {
        points_.resize(edges_.capacity());
    }
    kernels_.pierce(edges_.arrays(), planes.z(plane), graph_.slot_end(), points_.data());
    layers_.build(graph_, points_.data(), out);
}

void BandSweep::compact(PlaneIndex plane) {
    graph_.compact([&](std::span<const Slot> new_to_old) {
        std::pmr::vector<Slot> old_to_new(edges_.capacity(), no_link, points_.get_allocator());
        for (Slot slot = 0; slot < new_to_old.size(); ++slot) {
            old_to_new[new_to_old[slot]] = slot;
        }
        for (const std::uint32_t head : pending_head_) {
            for (std::uint32_t p = head; p != no_link; p = pending_[p].next) {
                pending_[p].long_edge = 2 * old_to_new[pending_[p].long_edge >> 1] + (pending_[p].long_edge & 1);
            }
        }
        edges_.compact(new_to_old, plane);
    });
}

SweepTicks BandSweep::take_ticks() noexcept {
    SweepTicks spent = std::exchange(ticks_, {});
    spent.nesting = std::exchange(layers_.nesting_ticks, 0);
    spent.contours -= std::min(spent.contours, spent.nesting);
    return spent;
}

}  // namespace lamella
