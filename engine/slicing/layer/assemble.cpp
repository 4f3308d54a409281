// The assembled form on a caller's own segments: Algorithm 4 of the paper, with keys from the caller.
#include "lamella/layers.hpp"

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/sort.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/contours/link_graph.hpp"
#include "slicing/layer/layer_builder.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_segments = std::size_t{1} << 30;  // two ends each must have 31-bit slots

class Assembly {
public:
    Assembly(std::span<const Segment> segments, const Context& context)
        : segments_(segments), stop_(context.stop), worker_(context.memory, stop_.check()) {}

    void link() {
        constexpr std::size_t segment_work = 32;  // two ends are looked up
        stop_.stop_if_asked();
        SlotTable::Attaching attaching = graph_.begin_attaching(2 * segments_.size());
        links_.reserve(segments_.size());
        worker_.in_stretches(0, segments_.size(), segment_work,
                             [&](std::size_t begin, std::size_t end) { attach_all(attaching, begin, end); });
        graph_.end_attaching(attaching, 2 * segments_.size());
        graph_.settle(links_, [this](std::span<MeetingEnd> ends) { sort_by_rank(ends); });
        graph_.connect(links_);
        grow_exactly(points_, graph_.capacity(), worker_);
        worker_.in_stretches(0, segments_.size(), 2, [&](std::size_t begin, std::size_t end) { put_points(begin, end); });
        graph_.walk();
    }

    SliceResult build() {
        output_.buffer.resize_discarding(segments_.size() + segments_.size() / 64 + 64);  // seldom more, see slice()
        output_.begin(output_.buffer.span());
        layer_.read(graph_, points_.data(), nullptr);
        layer_.build(output_);
        return copy_layer(output_, segments_.size(), worker_, worker_.memory());
    }

private:
    void attach_all(SlotTable::Attaching& attaching, std::size_t begin, std::size_t end) {
        for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
            const Segment& segment = segments_[i];
            const PortRef source = attach(attaching, segment.from_key, source_port, i);
            const PortRef target = attach(attaching, segment.to_key, target_port, i);
            links_.push_back({{target, source}});
        }
    }

    static PortRef attach(SlotTable::Attaching& attaching, const EndKey& key, int port, std::uint32_t link) {
        return attaching.attach(attaching.find_or_add(from_key(key), 0), port, link);
    }

    void put_points(std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            points_[slot_of(links_[i].ends[source_port])] = segments_[i].from;
            points_[slot_of(links_[i].ends[target_port])] = segments_[i].to;
        }
    }

    /// Equal ranks are sorted as equal angles are (see SlotTable::settle()): ends that come in first, then by the segment's
    /// other end.
    void sort_by_rank(std::span<MeetingEnd> ends) {
        constexpr std::size_t comparison_work = 8;
        const auto rank = [this](const MeetingEnd& end) {
            return end.is_source ? segments_[end.link].from_rank : segments_[end.link].to_rank;
        };
        const auto other_key = [this](const MeetingEnd& end) -> const EndKey& {
            return end.is_source ? segments_[end.link].to_key : segments_[end.link].from_key;
        };
        sort_briefly(ends.begin(), ends.end(), [&](const MeetingEnd& a, const MeetingEnd& b) {
            worker_.spend(comparison_work);
            if (rank(a) != rank(b)) {
                return rank(a) < rank(b);
            }
            if (a.is_source != b.is_source) {
                return !a.is_source;
            }
            const MeetingEnd& first = a.is_source ? b : a;
            const MeetingEnd& second = a.is_source ? a : b;
            return other_key(first) != other_key(second) ? other_key(first) < other_key(second) : first.link < second.link;
        });
    }

    std::span<const Segment> segments_;
    PacedStop stop_;
    Worker worker_;
    BandOutput output_{worker_.memory()};
    Vector<Link> links_{worker_.memory()};
    Vector<Point> points_{worker_.memory()};  // by slot
    LinkGraph graph_{worker_};
    LayerBuilder layer_{worker_};
};

}  // namespace

EndKey EndKey::of_edge(GridVertex u, GridVertex v) noexcept {
    const bool u_is_lower = u.z != v.z ? u.z < v.z : u < v;
    return to_key(u_is_lower ? MeshEdge::between(u, v) : MeshEdge::between(v, u));
}

Result<SliceResult> assemble(std::span<const Segment> segments, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceResult> {
        if (segments.size() > most_segments) {
            return Error{ErrorCode::invalid_argument, "more than 2^30 segments in one plane"};
        }
        Assembly assembly(segments, context);
        assembly.link();
        return assembly.build();
    });
}

}  // namespace lamella
