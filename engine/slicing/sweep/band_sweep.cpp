#include "slicing/sweep/band_sweep.hpp"

#include <algorithm>

#include "base/system/processor.hpp"
#include "lamella/context.hpp"

namespace lamella {

namespace {

// Work as StopPace counts it: an event looks up two edges and writes a link.
constexpr std::size_t event_work = 16;
constexpr std::size_t edge_work = 4;
constexpr std::size_t plane_work = 64;

/// Calls take(i) for events [begin, end), in stretches between which a stop is noticed.
template <class Take>
void each_event(Worker& worker, std::size_t begin, std::size_t end, Take take) {
    worker.in_stretches(begin, end, event_work, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            take(i);
        }
    });
}

}  // namespace

void BandSweep::run(const Band& band, std::span<const std::uint32_t> seeds, const Buckets& buckets, const PlaneSet& planes,
                    ContourForm form, const StopCheck& stop, BandOutput& out) {
    worker_.follow(stop);
    with_origins_ = out.with_origins;
    begin(band, buckets);
    for (PlaneIndex plane = band.first; plane < band.last; ++plane) {
        worker_.spend(plane_work);
        const bool timed = plane % timing_stride == 0;
        layers_.ticks = timed ? &ticks_ : nullptr;
        const std::uint64_t start = timed ? ticks() : 0;
        const auto seeds_here = plane == band.first ? seeds : std::span<const std::uint32_t>{};
        if (form == ContourForm::assembled) {
            enter_active(plane, seeds_here);
        } else {
            take_events(plane, seeds_here, buckets.list_of(plane));
        }
        link_events(plane);
        graph_.walk();
        const std::uint64_t linked = timed ? ticks() : 0;
        if (graph_.live() == 0) {
            out.add_empty_layer();
        } else {
            pierce(planes.z(plane));
            layers_.read(graph_, points_.data(), with_origins_ ? origins_.data() : nullptr);
            layers_.build(out);
        }
        if (timed) {
            ticks_.sweep += linked - start;
            ticks_.contours += ticks() - linked;
        }
        out.finish_layer();
    }
}

void BandSweep::begin(const Band& band, const Buckets& buckets) {
    band_ = band;
    buckets_ = &buckets;
    // In a closed mesh a plane has as many edges as segments.
    const std::size_t edges = *std::max_element(buckets.segments.begin() + band.first, buckets.segments.begin() + band.last);
    most_segments_ = std::max(most_segments_, edges);
    graph_.clear();
    graph_.reserve(edges + 128);
    pending_count_ = 0;
    active_.clear();
}

// --- Events

/// Takes a plane's events. The counters are members here, as in SlotTable::Attaching and for the same reason.
class BandSweep::Events {
public:
    Events(BandSweep& sweep, std::size_t attachments)
        : attaching_(sweep.graph_.begin_attaching(attachments)),
          records_(sweep.buckets_->records.data()),
          links_(sweep.links_.data()),
          pending_(sweep.pending_.data()),
          pending_plane_(sweep.pending_plane_.data()),
          pending_count_(sweep.pending_count_),
          band_last_(sweep.band_.last) {}

    void pass_middle(const Pending& pending) {
        const CrossedTriangle& t = records_[pending.record];
        const int long_port = t.long_edge_is_source() ? source_port : target_port;
        link(pending.record, long_port, pending.long_end, attach(short_edge(t, true), t.last, 1 - long_port));
    }

    void enter(std::uint32_t record, PlaneIndex plane) {
        const CrossedTriangle& t = records_[record];
        const PlaneIndex middle = t.middle_plane();
        const auto above_middle = static_cast<std::uint32_t>(middle <= plane);
        const int long_port = t.long_edge_is_source() ? source_port : target_port;
        const PortRef long_end = attach(long_edge(t), t.last, long_port);
        // Selects `middle` or `last`, and below adds 0 or 1, without a branch: no predictor knows the middle vertex.
        const PlaneIndex end = middle ^ ((middle ^ t.last) & (0U - above_middle));
        const PortRef short_end = attach(short_edge(t, above_middle != 0), end, 1 - long_port);
        link(record, long_port, long_end, short_end);
        pending_[pending_count_] = {record, long_end};
        pending_plane_[pending_count_] = middle;
        // No plane may lie between the middle vertex and the upper one.
        const auto has_middle_event = static_cast<std::uint32_t>(middle < std::min(t.last, band_last_));
        pending_count_ += has_middle_event & (1U - above_middle);
    }

    std::uint32_t link_count() const noexcept { return link_count_; }
    std::uint32_t pending_count() const noexcept { return pending_count_; }
    const SlotTable::Attaching& attaching() const noexcept { return attaching_; }

private:
    PortRef attach(const MeshEdge& edge, PlaneIndex end, int port) {
        return attaching_.attach(attaching_.find_or_add(edge, end), port, link_count_);
    }

    /// The long edge is source or target as the triangle says, the short one the other.
    void link(std::uint32_t record, int long_port, PortRef long_end, PortRef short_end) {
        // Stored by index, as a branch would be mispredicted. Both ends are later read one by one: one wide load would wait
        // for the two stores.
        links_[link_count_].ends[long_port] = long_end;
        links_[link_count_].ends[1 - long_port] = short_end;
        links_[link_count_].record = record;
        ++link_count_;
    }

    SlotTable::Attaching attaching_;
    const CrossedTriangle* records_;
    Link* links_;
    Pending* pending_;
    PlaneIndex* pending_plane_;
    std::uint32_t link_count_ = 0;
    std::uint32_t pending_count_;
    PlaneIndex band_last_;
};

/// Edges that end leave, middle vertices are passed, seeds enter, and triangles of the plane's list from `list_begin` on.
void BandSweep::take_events(PlaneIndex plane, std::span<const std::uint32_t> seeds, std::uint32_t list_begin) {
    graph_.release_ended(plane);
    const std::uint32_t list_end = buckets_->list_of(plane + 1);
    const std::span<const Pending> passing = take_passing(plane);
    const std::size_t entering = seeds.size() + list_end - list_begin;
    link_count_ = 0;
    if (entering + passing.size() == 0) {
        return;
    }
    reserve_events(entering + passing.size(), entering);
    Events events(*this, 2 * entering + passing.size());
    each_event(worker_, 0, passing.size(), [&](std::size_t i) { events.pass_middle(passing[i]); });
    first_entering_ = events.link_count();
    each_event(worker_, 0, seeds.size(), [&](std::size_t i) { events.enter(seeds[i], plane); });
    each_event(worker_, list_begin, list_end,
               [&](std::size_t record) { events.enter(static_cast<std::uint32_t>(record), plane); });
    link_count_ = events.link_count();
    first_new_pending_ = std::exchange(pending_count_, events.pending_count());
    graph_.end_attaching(events.attaching(), 2 * entering + passing.size());
}

/// Takes the triangles whose middle vertex lies below `plane` and not below the one before, and prefetches their records,
/// which were last read when they entered.
std::span<const BandSweep::Pending> BandSweep::take_passing(PlaneIndex plane) {
    if (passing_at_.size() < pending_count_ + select_padding) {
        grow_exactly(passing_at_, pending_plane_.size() + select_padding, worker_);
    }
    const std::size_t count = kernels_.select_equal(pending_plane_.data(), pending_count_, plane, passing_at_.data());
    if (passing_.size() < count) {
        passing_.resize(count);
    }
    for (std::size_t i = 0; i < count; ++i) {
        passing_[i] = pending_[passing_at_[i]];
        const auto* record = reinterpret_cast<const char*>(&buckets_->records[passing_[i].record]);
        prefetch_to_read(record);
        prefetch_to_read(record + sizeof(CrossedTriangle) - 1);
    }
    for (std::size_t i = count; i-- > 0;) {  // the last ones move into the gaps
        --pending_count_;
        pending_[passing_at_[i]] = pending_[pending_count_];
        pending_plane_[passing_at_[i]] = pending_plane_[pending_count_];
    }
    return {passing_.data(), count};
}

void BandSweep::reserve_events(std::size_t links, std::size_t middles) {
    grow_exactly(links_, links, worker_);
    if (const std::size_t pending = pending_count_ + middles + 1; pending_.size() < pending) {
        grow_exactly(pending_plane_, pending + pending / 8, worker_);
        grow_exactly(pending_, pending_plane_.size(), worker_);  // the last, by whose size there is room
    }
}

/// Assembled form: the links of the plane before are forgotten, the active set is brought up to date (Algorithm 1, steps 7
/// to 12), and every triangle in it enters anew.
void BandSweep::enter_active(PlaneIndex plane, std::span<const std::uint32_t> seeds) {
    graph_.clear();
    pending_count_ = 0;
    std::erase_if(active_, [&](std::uint32_t record) {
        worker_.spend(1);
        return buckets_->records[record].last <= plane;
    });
    const std::uint32_t list_end = buckets_->list_of(plane + 1);
    reserve_more(active_, active_.size() + seeds.size() + (list_end - buckets_->list_of(plane)));
    active_.insert(active_.end(), seeds.begin(), seeds.end());
    for (std::uint32_t record = buckets_->list_of(plane); record < list_end; ++record) {
        active_.push_back(record);
        worker_.spend(1);
    }
    take_events(plane, active_, list_end);
}

void BandSweep::link_events(PlaneIndex plane) {
    if (link_count_ == 0) {
        return;
    }
    const std::span<Link> links{links_.data(), link_count_};
    if (graph_.settle(links, [this](std::span<MeetingEnd> ends) { sort_meeting(ends); })) {
        correct_pending();
    }
    graph_.connect(links);
    edges_.reserve(graph_.capacity(), worker_);
    const std::span<const Slot> fresh = graph_.fresh();
    worker_.in_stretches(0, fresh.size(), edge_work, [&](std::size_t begin, std::size_t end) {
        for (const Slot slot : fresh.subspan(begin, end - begin)) {
            edges_.put(slot, graph_.edge(slot));
        }
    });
    if (with_origins_) {
        put_origins(plane);
    }
}

/// At irregular edges, new links' long edges may have moved to other slots.
void BandSweep::correct_pending() {
    std::uint32_t link = first_entering_;
    for (std::uint32_t p = first_new_pending_; p < pending_count_; ++p, ++link) {
        while (links_[link].record != pending_[p].record) {
            ++link;
        }
        const CrossedTriangle& t = buckets_->records[pending_[p].record];
        pending_[p].long_end = links_[link].ends[t.long_edge_is_source() ? source_port : target_port];
    }
}

/// Sorts the ends at an irregular edge by their faces' angles round it.
void BandSweep::sort_meeting(std::span<MeetingEnd> ends) {
    worker_.spend(event_work * ends.size());
    faces_.clear();
    const GridVertex lower = graph_.edge(ends.front().slot).lower();
    const GridVertex upper = graph_.edge(ends.front().slot).upper();
    for (const MeetingEnd& end : ends) {
        const CrossedTriangle& t = buckets_->records[links_[end.link].record];
        const bool has_lowest = t.lower == lower || t.lower == upper;
        const bool has_middle = t.middle == lower || t.middle == upper;
        faces_.push_back({!has_lowest ? t.lower : (has_middle ? t.upper : t.middle), t.triangle, end});
    }
    sort_round_edge(lower, upper, faces_);
    if (with_origins_) {
        note_substitutes();
    }
    std::transform(faces_.begin(), faces_.end(), ends.begin(), [](const FaceAtEdge& face) { return face.end; });
}

// --- The plane

/// Finds where the active edges pierce the plane.
void BandSweep::pierce(std::int32_t z) {
    grow_exactly(points_, edges_.capacity(), worker_);
    worker_.in_stretches(0, graph_.slot_end(), 1, [&](std::size_t begin, std::size_t end) {
        kernels_.pierce(edges_.arrays(begin), z, end - begin, points_.data() + begin);
    });
}

SweepTicks BandSweep::take_ticks() noexcept {
    SweepTicks spent = std::exchange(ticks_, {});
    spent.contours -= std::min(spent.contours, spent.nesting + spent.fill);
    return spent;
}

// Where the segments of a band come from. What a port holds changes only when its link is written, as the links do: the
// origin of a segment that stays from plane to plane is never computed again.

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
    const std::uint32_t record = links_[link].record;
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
                substitutes_.push_back({face->end.link, links_[smallest->end.link].record});
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
