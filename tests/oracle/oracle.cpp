#include "oracle/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

namespace oracle {

using lamella::GridVertex;
using lamella::Point;
using lamella::Role;

namespace {

/// One end of a face's segment. The face's third vertex gives the direction in which the segment leaves the edge.
struct End {
    std::size_t segment = 0;
    bool out = false;  ///< the source: the face runs down this edge
    GridVertex third;
    Crossing at;
    std::uint32_t rank = 0;
    std::size_t mate = none;  ///< the end that continues the contour

    static constexpr std::size_t none = static_cast<std::size_t>(-1);
};

Crossing crossing_of(GridVertex u, GridVertex v, std::int32_t z) {
    const auto [low, high] = u.z < v.z ? EdgeKey{u, v} : EdgeKey{v, u};
    const double rise = static_cast<double>(z) - low.z;
    const double sx = (static_cast<double>(high.x) - low.x) / (static_cast<double>(high.z) - low.z);
    const double sy = (static_cast<double>(high.y) - low.y) / (static_cast<double>(high.z) - low.z);
    const auto rounded = [](double move) {  // to multiples of 2^-20 first, so that nearly ties are ties
        constexpr double room = 0x1.8p32;
        return static_cast<std::int32_t>(std::nearbyint(move + room - room));
    };
    const Point point{low.x + rounded(sx * rise), low.y + rounded(sy * rise)};
    return {point, {low, high}};
}

/// Segment s has its source at index 2s and its target at 2s + 1.
std::vector<End> ends_at(std::span<const Triangle> triangles, std::int32_t z) {
    std::vector<End> ends;
    for (const Triangle& t : triangles) {
        End pair[2];
        bool crossed = false;
        for (std::size_t i = 0; i < 3; ++i) {
            const GridVertex u = t[i];
            const GridVertex v = t[(i + 1) % 3];
            if ((u.z < z) != (v.z < z)) {
                const bool down = v.z < z;
                pair[down ? 0 : 1] = End{ends.size() / 2, down, t[(i + 2) % 3], crossing_of(u, v, z)};
                crossed = true;
            }
        }
        if (crossed) {
            ends.insert(ends.end(), std::begin(pair), std::end(pair));
        }
    }
    return ends;
}

struct Direction {
    Int128 x = 0;
    Int128 y = 0;
};

/// The direction of a face as seen along its edge from above: its third vertex, shifted along the edge to the edge's foot.
Direction direction_of(const EdgeKey& edge, GridVertex third) {
    const auto& [low, high] = edge;
    const Int128 dz = Int128{high.z} - low.z;
    const Int128 rise = Int128{third.z} - low.z;
    return {(Int128{third.x} - low.x) * dz - (Int128{high.x} - low.x) * rise,
            (Int128{third.y} - low.y) * dz - (Int128{high.y} - low.y) * rise};
}

/// True if a comes before b counter-clockwise from `zero`.
bool before(Direction zero, Direction a, Direction b) {
    const auto cross = [](Direction u, Direction v) { return u.x * v.y - u.y * v.x; };
    const auto second_half = [&](Direction d) {
        return cross(zero, d) < 0 || (cross(zero, d) == 0 && zero.x * d.x + zero.y * d.y < 0);
    };
    return second_half(a) != second_half(b) ? second_half(b) : cross(a, b) > 0;
}

/// Sorts the ends at one edge counter-clockwise from the smallest third vertex. A third vertex in line with the edge has
/// no angle and is placed at angle zero. At equal angles, targets come first, then sources in the opposite order. Brackets
/// then nest, and each of several equal faces keeps its place from edge to edge.
void sort_around(std::vector<End*>& around) {
    const EdgeKey edge = around.front()->at.edge;
    const auto no_angle = [](Direction d) { return d.x == 0 && d.y == 0; };
    const End* first = nullptr;
    for (const End* end : around) {
        if (!no_angle(direction_of(edge, end->third)) && (first == nullptr || end->third < first->third)) {
            first = end;
        }
    }
    const Direction zero = first != nullptr ? direction_of(edge, first->third) : Direction{1, 0};
    const auto angle_of = [&](const End* end) {
        const Direction direction = direction_of(edge, end->third);
        return no_angle(direction) ? zero : direction;
    };
    std::sort(around.begin(), around.end(), [&](const End* a, const End* b) {
        const Direction da = angle_of(a);
        const Direction db = angle_of(b);
        if (before(zero, da, db) || before(zero, db, da)) {
            return before(zero, da, db);
        }
        if (a->out != b->out) {
            return b->out;
        }
        const std::pair place_a(a->third, a->segment);
        const std::pair place_b(b->third, b->segment);
        return a->out ? place_b < place_a : place_a < place_b;
    });
}

/// Pairs each target with the next source clockwise, as brackets match around a circle. Then pairs the remaining ends two
/// by two.
void pair_around(std::span<End* const> around, std::vector<End>& ends) {
    const auto join = [&](End* a, End* b) {
        a->mate = static_cast<std::size_t>(b - ends.data());
        b->mate = static_cast<std::size_t>(a - ends.data());
    };
    std::vector<End*> open;
    for (int turn = 0; turn < 2; ++turn) {
        for (End* end : around) {
            if (end->mate != End::none) {
                continue;
            }
            if (end->out && turn == 0) {
                open.push_back(end);
            } else if (!end->out && !open.empty()) {
                join(end, open.back());
                open.pop_back();
            }
        }
    }
    End* waiting = nullptr;
    for (End* end : around) {
        if (end->mate == End::none && waiting != nullptr) {
            join(waiting, end);
            waiting = nullptr;
        } else if (end->mate == End::none) {
            waiting = end;
        }
    }
}

std::vector<End> linked_ends(std::span<const Triangle> triangles, std::int32_t z) {
    std::vector<End> ends = ends_at(triangles, z);
    std::map<EdgeKey, std::vector<End*>> at_edge;
    for (End& end : ends) {
        at_edge[end.at.edge].push_back(&end);
    }
    for (auto& [edge, around] : at_edge) {
        sort_around(around);
        for (std::size_t rank = 0; rank < around.size(); ++rank) {
            around[rank]->rank = static_cast<std::uint32_t>(rank);
        }
        pair_around(around, ends);
    }
    return ends;
}

struct Walk {
    std::vector<Crossing> crossings;
    std::uint32_t segments = 0;
    std::int64_t votes = 0;  ///< segments walked forwards minus segments walked backwards
    bool closed = false;
};

Walk walk_from(std::size_t first, const std::vector<End>& ends, std::vector<char>& used) {
    Walk walk;
    std::size_t near = first;
    while (near != End::none && used[near / 2] == 0) {
        used[near / 2] = 1;
        ++walk.segments;
        walk.votes += ends[near].out ? 1 : -1;
        walk.crossings.push_back(ends[near].at);
        const std::size_t far = near ^ 1U;
        near = ends[far].mate;
        if (near == End::none) {
            walk.crossings.push_back(ends[far].at);
        }
    }
    walk.closed = near != End::none;
    return walk;
}

/// The points from the canonical start on, without equal successive points.
std::vector<Point> canonical_points(std::vector<Crossing>& crossings, bool closed) {
    if (closed) {
        std::rotate(crossings.begin(), std::min_element(crossings.begin(), crossings.end()), crossings.end());
    }
    std::vector<Point> points;
    for (const Crossing& crossing : crossings) {
        if (points.empty() || points.back() != crossing.point) {
            points.push_back(crossing.point);
        }
    }
    while (closed && points.size() > 1 && points.back() == points.front()) {
        points.pop_back();
    }
    return points;
}

/// The mesh edges along a walk. For a closed walk, the rotation that compares smallest.
std::vector<EdgeKey> reading_of(const std::vector<Crossing>& crossings, bool closed) {
    std::vector<EdgeKey> edges;
    edges.reserve(crossings.size());
    for (const Crossing& crossing : crossings) {
        edges.push_back(crossing.edge);
    }
    std::vector<EdgeKey> smallest = edges;
    for (std::size_t turn = 0; closed && turn < edges.size(); ++turn) {
        std::rotate(edges.begin(), edges.begin() + 1, edges.end());
        smallest = std::min(smallest, edges);
    }
    return smallest;
}

/// A walk gets the orientation of most of its segments. In a tie, it gets the direction in which its edges compare
/// smaller.
bool runs_backwards(const Walk& walk) {
    if (walk.votes != 0) {
        return walk.votes < 0;
    }
    const std::vector<Crossing> back(walk.crossings.rbegin(), walk.crossings.rend());
    return reading_of(back, walk.closed) < reading_of(walk.crossings, walk.closed);
}

Contour contour_of(Walk walk) {
    if (runs_backwards(walk)) {
        std::reverse(walk.crossings.begin(), walk.crossings.end());
    }
    Contour contour;
    contour.segments = walk.segments;
    contour.flags = std::abs(walk.votes) == walk.segments ? 0U : unsigned{lamella::orientation_mixed};
    contour.points = canonical_points(walk.crossings, walk.closed);
    contour.start = walk.crossings.front();
    contour.start_is_unique = std::count(walk.crossings.begin(), walk.crossings.end(), contour.start) == 1;
    if (walk.closed) {
        contour.twice_area = rings::twice_area(contour.points);
        contour.orientation = (contour.twice_area > 0) - (contour.twice_area < 0);
        contour.role = contour.orientation == 0 ? Role::flat : Role::outer;
    }
    return contour;
}

Int128 size_of(const Contour& contour) {
    return contour.twice_area < 0 ? -contour.twice_area : contour.twice_area;
}

/// Smaller by area; of equal areas, the contour that starts first; then by box and points.
bool smaller(const Contour& a, const Contour& b) {
    if (size_of(a) != size_of(b)) {
        return size_of(a) < size_of(b);
    }
    const auto order = [](const Contour& contour) {
        Point low = contour.points.front();
        Point high = low;
        for (const Point p : contour.points) {
            low = {std::min(low.x, p.x), std::min(low.y, p.y)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
        return std::tuple(contour.points.front(), low, high, contour.points.size(), contour.points);
    };
    return order(a) < order(b);
}

/// Sorted by start, then each hole moved after its outer.
Layer in_order(const Layer& layer) {
    const auto owner = [&](std::size_t c) {
        const std::size_t hole = c;
        while (layer[hole].role == Role::hole && (c == hole || layer[c].role != Role::outer)) {
            c = static_cast<std::size_t>(layer[c].parent);
        }
        return c;
    };
    std::vector<std::size_t> order(layer.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto place = [&](std::size_t c) {
        const std::size_t head = owner(c);
        return std::tuple(layer[head].start, layer[head].points, head, head != c, layer[c].start, layer[c].points);
    };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
    Layer sorted;
    for (const std::size_t c : order) {
        sorted.push_back(layer[c]);
        if (layer[c].parent >= 0) {
            const auto parent = std::find(order.begin(), order.end(), static_cast<std::size_t>(layer[c].parent));
            sorted.back().parent = static_cast<int>(parent - order.begin());
        }
    }
    return sorted;
}

}  // namespace

void find_parents(Layer& layer) {
    for (Contour& child : layer) {
        for (std::size_t i = 0; i < layer.size() && child.orientation != 0; ++i) {
            if (layer[i].orientation != 0 && rings::strictly_around(layer[i].points, child.points.front()) &&
                (child.parent < 0 || smaller(layer[i], layer[static_cast<std::size_t>(child.parent)]))) {
                child.parent = static_cast<int>(i);
            }
        }
    }
}

void decide_roles(Layer& layer) {
    for (Contour& contour : layer) {
        std::vector<int> orientations;  // from the contour out to its outermost ancestor
        for (const Contour* c = &contour; c->orientation != 0; c = &layer[static_cast<std::size_t>(c->parent)]) {
            orientations.push_back(c->orientation);
            if (c->parent < 0) {
                break;
            }
        }
        int winding = 0;
        bool negative = false;
        for (std::size_t i = orientations.size(); i-- > 0;) {
            winding += orientations[i];
            negative = negative || winding < 0;
        }
        if (contour.orientation != 0) {
            const bool outer = negative ? orientations.size() % 2 == 1 : contour.orientation > 0;
            contour.role = outer ? Role::outer : Role::hole;
            contour.flags |= negative ? unsigned{lamella::orientation_overruled} : 0U;
        }
    }
    for (Contour& contour : layer) {
        if (contour.orientation != 0 && (contour.role == Role::outer) != (contour.twice_area > 0)) {
            std::reverse(contour.points.begin() + 1, contour.points.end());
            contour.twice_area = -contour.twice_area;
        }
    }
}

std::vector<Triangle> quantise(std::span<const double> coordinates, double unit_mm) {
    const auto even = [&](double mm) { return 2 * static_cast<std::int32_t>(std::nearbyint(mm / (2 * unit_mm))); };
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i + 9 <= coordinates.size(); i += 9) {
        Triangle t;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const double* xyz = &coordinates[i + 3 * corner];
            t[corner] = {even(xyz[0]), even(xyz[1]), even(xyz[2])};
        }
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) {
            triangles.push_back(t);
        }
    }
    return triangles;
}

std::vector<double> distinct(std::vector<double> heights, double unit_mm) {
    const auto on_grid = [&](double mm) { return std::nearbyint(mm / (2 * unit_mm)); };
    std::sort(heights.begin(), heights.end());
    const auto equal = [&](double a, double b) { return on_grid(a) == on_grid(b); };
    heights.erase(std::unique(heights.begin(), heights.end(), equal), heights.end());
    return heights;
}

std::vector<double> vertex_heights(std::span<const double> soup, double unit_mm) {
    std::vector<double> heights;
    for (std::size_t i = 2; i < soup.size(); i += 3) {
        heights.push_back(soup[i]);
    }
    return distinct(std::move(heights), unit_mm);
}

std::vector<lamella::Segment> segments_at(std::span<const Triangle> triangles, std::int32_t z) {
    const std::vector<End> ends = linked_ends(triangles, z);
    std::vector<lamella::Segment> segments;
    for (std::size_t i = 0; i < ends.size(); i += 2) {
        const auto key = [](const EdgeKey& edge) { return lamella::EndKey::of_edge(edge.first, edge.second); };
        segments.push_back({key(ends[i].at.edge), key(ends[i + 1].at.edge), ends[i].at.point, ends[i + 1].at.point,
                            ends[i].rank, ends[i + 1].rank});
    }
    return segments;
}

Layer slice_at(std::span<const Triangle> triangles, std::int32_t z) {
    const std::vector<End> ends = linked_ends(triangles, z);
    std::vector<char> used(ends.size() / 2, 0);
    Layer layer;
    for (const bool closed : {false, true}) {
        for (std::size_t end = 0; end < ends.size(); ++end) {
            if (used[end / 2] == 0 && (closed || ends[end].mate == End::none)) {
                layer.push_back(contour_of(walk_from(end, ends, used)));
            }
        }
    }
    find_parents(layer);
    decide_roles(layer);
    return in_order(layer);
}

}  // namespace oracle
