// The assembled form on a caller's own segments: Algorithm 4 of the paper, with keys from the caller.
#include "lamella/assemble.hpp"

#include <algorithm>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/vector.hpp"
#include "slicing/contours/layer_builder.hpp"
#include "slicing/contours/link_graph.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_segments = std::size_t{1} << 30;  // two ends each must have 31-bit slots

class Assembly {
public:
    Assembly(std::span<const Segment> segments, const Memory* memory)
        : segments_(segments), graph_(memory), layer_(memory), output_(memory), links_(memory), points_(memory) {}

    void link() {
        SlotTable::Attaching attaching = graph_.begin_attaching(2 * segments_.size());
        links_.reserve(segments_.size());
        for (std::uint32_t i = 0; i < segments_.size(); ++i) {
            const Segment& segment = segments_[i];
            const PortRef source = attach(attaching, segment.from_key, segment.from, source_port, i);
            const PortRef target = attach(attaching, segment.to_key, segment.to, target_port, i);
            links_.push_back({{target, source}});
        }
        graph_.end_attaching(attaching, 2 * segments_.size());
        graph_.settle(
            links_, [this](Slot, std::span<MeetingEnd> ends) { sort_by_rank(ends); },
            [this](Slot to, Slot from) { put(to, Point(points_[from])); });
        graph_.connect(links_);
        graph_.walk();
    }

    LayerContours build(const Memory* memory) {
        output_.begin({});
        layer_.build(graph_, points_.data(), output_);
        LayerContours layer{Array<Contour>(memory), Array<Point>(memory)};
        layer.contours.resize_discarding(output_.contours.size());
        std::copy(output_.contours.begin(), output_.contours.end(), layer.contours.begin());
        layer.points.resize_discarding(output_.point_count);
        std::copy_n(output_.points, output_.point_count, layer.points.begin());
        return layer;
    }

private:
    PortRef attach(SlotTable::Attaching& attaching, const EndKey& key, Point point, int port, std::uint32_t link) {
        const Slot slot = attaching.find_or_add(from_key(key), 0);
        put(slot, point);
        return attaching.attach(slot, port, link);
    }

    void put(Slot slot, Point point) {
        if (slot >= points_.size()) {
            points_.resize(std::max<std::size_t>(1024, 2 * points_.size()));
        }
        points_[slot] = point;
    }

    /// Equal ranks are sorted as equal angles are (see pairing.hpp): ends that come in first, then by the segment's other
    /// end.
    void sort_by_rank(std::span<MeetingEnd> ends) const {
        const auto rank = [this](const MeetingEnd& end) {
            return end.is_source ? segments_[end.link].from_rank : segments_[end.link].to_rank;
        };
        const auto other_key = [this](const MeetingEnd& end) -> const EndKey& {
            return end.is_source ? segments_[end.link].to_key : segments_[end.link].from_key;
        };
        std::sort(ends.begin(), ends.end(), [&](const MeetingEnd& a, const MeetingEnd& b) {
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
    LinkGraph graph_;
    LayerBuilder layer_;
    BandOutput output_;
    Vector<Link> links_;
    Vector<Point> points_;  // by slot
};

}  // namespace

EndKey EndKey::of_edge(GridVertex u, GridVertex v) noexcept {
    const bool u_is_lower = u.z != v.z ? u.z < v.z : u < v;
    return to_key(u_is_lower ? MeshEdge::between(u, v) : MeshEdge::between(v, u));
}

Result<LayerContours> assemble(std::span<const Segment> segments, const Control& control) noexcept {
    return guarded(control, [&]() -> Result<LayerContours> {
        if (segments.size() > most_segments) {
            return Error{ErrorCode::invalid_argument, "more than 2^30 segments in one plane"};
        }
        stop_if_asked(control);
        Assembly assembly(segments, control.memory);
        assembly.link();
        stop_if_asked(control);
        return assembly.build(control.memory);
    });
}

}  // namespace lamella
