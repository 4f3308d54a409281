// Minetto et al. 2017, Algorithm 4. Each plane has its own hash table, which maps each point to its two neighbours.
// Contours are read out of it point by point. O(m) expected.
//
// Errors of the printed text that are corrected here:
// - The entry of `last` is never removed.
// - The loop advances to p_2 before it tests whether p_2 is `last`. In a contour of two segments it is.
// - Section 4.1 lets any number of segments meet in a point, but an entry holds only two. Here such a point has several
//   entries under numbered keys. Contours that touch may therefore fuse or be split.
// - An open polyline ends at an entry with one neighbour. It is then followed from p_1 towards `last`.
// - A segment of no length after rounding would be its own neighbour. It is dropped.
#include "methods.hpp"

#include <algorithm>
#include <unordered_map>

namespace lamella::baselines {

namespace {

/// A point in which two segments meet. Where more meet, further nodes have higher `copy` numbers.
struct Joint {
    Point at;
    std::uint32_t copy = 0;
    friend bool operator==(const Joint&, const Joint&) = default;
};
constexpr Joint null{{}, ~0U};

struct JointHash {
    std::size_t operator()(const Joint& joint) const noexcept {
        const auto x = std::uint64_t{static_cast<std::uint32_t>(joint.at.x)};
        const auto y = std::uint64_t{static_cast<std::uint32_t>(joint.at.y)};
        const std::uint64_t mixed = ((x << 32 | y) + joint.copy) * 0x9E3779B97F4A7C15U;
        return mixed ^ mixed >> 32;
    }
};

struct Entry {
    Joint v = null;
    Joint w = null;
    std::uint32_t segments_met = 0;  // number of segment ends in the point; counted in its first copy only
};

using Table = std::unordered_map<Joint, Entry, JointHash>;

/// The node that takes the next segment ending in the point.
Table::value_type& place_for(Table& table, Point at) {
    Table::value_type& first = *table.try_emplace(Joint{at, 0}).first;
    const std::uint32_t copy = first.second.segments_met++ / 2;
    return copy == 0 ? first : *table.try_emplace(Joint{at, copy}).first;
}

void insert(Entry& entry, const Joint& neighbour) {
    (entry.v == null ? entry.v : entry.w) = neighbour;
}

Entry remove_entry(Table& table, const Joint& key) {
    const auto found = table.find(key);
    const Entry entry = found->second;
    table.erase(found);
    return entry;
}

/// Steps 14 to 22: appends points from p_j on. Returns true when it reaches `last`, false at a free border.
bool follow(Table& table, Joint previous, Joint p_j, const Joint& last, std::vector<Point>& points) {
    while (p_j != null) {
        points.push_back(p_j.at);
        const Entry entry = remove_entry(table, p_j);
        if (p_j == last) {
            return true;
        }
        const Joint next = entry.v == previous ? entry.w : entry.v;
        previous = p_j;
        p_j = next;
    }
    return false;
}

Polyline remove_polyline(Table& table) {
    const Joint p_1 = table.begin()->first;
    const auto [p_2, last, unused] = remove_entry(table, p_1);
    Polyline polyline{{p_1.at}, false};
    polyline.closed = follow(table, p_1, p_2, last, polyline.points);
    if (!polyline.closed) {
        std::reverse(polyline.points.begin(), polyline.points.end());
        follow(table, p_1, last, null, polyline.points);
    }
    return polyline;
}

std::vector<Polyline> join_plane(const std::vector<Segment>& segments) {
    Table table;
    table.reserve(segments.size());
    for (const Segment& segment : segments) {
        if (segment.from != segment.to) {
            auto& [u, entry_of_u] = place_for(table, segment.from);
            auto& [v, entry_of_v] = place_for(table, segment.to);
            insert(entry_of_u, v);
            insert(entry_of_v, u);
        }
    }
    std::vector<Polyline> polylines;
    while (!table.empty()) {
        polylines.push_back(remove_polyline(table));
    }
    return polylines;
}

}  // namespace

const ContourMethod hashed_contours{.name = "hashed", .join_plane = join_plane};

}  // namespace lamella::baselines
