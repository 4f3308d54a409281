#include "slicing/regions/arrangement.hpp"

#include <algorithm>

#include "base/sort.hpp"

namespace lamella {

namespace {

// As StopPace counts it; memory is not read in order.
constexpr std::size_t half_work = 48;
constexpr std::size_t scatter_work = 24;

/// Counter-clockwise around `centre`, beginning at the left; no two points lie in the same direction.
class AroundPoint {
public:
    explicit AroundPoint(Point centre) noexcept : centre_(centre) {}

    bool operator()(Point a, Point b) const noexcept {
        const bool a_above = is_above(a);
        return a_above != is_above(b) ? !a_above : product(a, b) > product(b, a);
    }

private:
    bool is_above(Point p) const noexcept { return p.y > centre_.y || (p.y == centre_.y && p.x > centre_.x); }
    std::int64_t product(Point a, Point b) const noexcept {
        return (std::int64_t{a.x} - centre_.x) * (std::int64_t{b.y} - centre_.y);
    }
    Point centre_;
};

}  // namespace

void Arrangement::build(const SnapRounding& snapped) {
    snapped_ = &snapped;
    sort_halves();
    find_faces();
    outer_faces_.clear();
    component_of_.assign(snapped.vertices().size(), none);
    for (std::uint32_t v = 0; v < snapped.vertices().size(); ++v) {
        if (component_of_[v] == none && first_halves_[v] != first_halves_[v + 1]) {
            spread_windings(v);
        }
    }
    if (snapped.any_cancelled()) {
        find_outer_faces();
    }
}

void Arrangement::sort_halves() {
    const auto count = static_cast<std::uint32_t>(2 * snapped_->strands().size());
    first_halves_.assign(snapped_->vertices().size() + 1, 0);
    worker_.in_stretches(0, count, scatter_work, [&](std::size_t begin, std::size_t end) {
        for (auto half = static_cast<Half>(begin); half < end; ++half) {
            ++first_halves_[from(half) + 1];
        }
    });
    for (std::size_t v = 1; v < first_halves_.size(); ++v) {
        first_halves_[v] += first_halves_[v - 1];
    }
    worker_.spend(first_halves_.size());
    stack_.assign(first_halves_.begin(), first_halves_.end());  // where the next half of each vertex goes
    halves_.resize(count);
    worker_.in_stretches(0, count, scatter_work, [&](std::size_t begin, std::size_t end) {
        for (auto half = static_cast<Half>(begin); half < end; ++half) {
            halves_[stack_[from(half)]++] = half;
        }
    });
    place_of_.resize(count);
    for (std::uint32_t v = 0; v + 1 < first_halves_.size(); ++v) {
        const AroundPoint is_before(snapped_->vertices()[v]);
        const auto begin = halves_.begin() + first_halves_[v];
        const auto end = halves_.begin() + first_halves_[v + 1];
        sort_briefly(begin, end, [&](Half a, Half b) { return is_before(point_of(a, 1), point_of(b, 1)); });
        for (auto half = begin; half != end; ++half) {
            place_of_[*half] = static_cast<std::uint32_t>(half - halves_.begin());
        }
        worker_.spend(half_work * static_cast<std::size_t>(end - begin));
    }
}

void Arrangement::find_faces() {
    faces_.clear();
    face_of_.assign(halves_.size(), none);
    for (Half first = 0; first < halves_.size(); ++first) {
        if (face_of_[first] != none) {
            continue;
        }
        const auto face = static_cast<std::uint32_t>(faces_.size());
        faces_.push_back({first, none, 0});
        for (Half half = first; face_of_[half] == none; half = next_around_face(half)) {
            face_of_[half] = face;
            worker_.spend(half_work);
        }
    }
}

/// Begins at the smallest vertex of a component. The last half around it has the left side on its left.
void Arrangement::spread_windings(std::uint32_t vertex) {
    const auto component = static_cast<std::uint32_t>(outer_faces_.size());
    const std::uint32_t outer = face_of_[halves_[first_halves_[vertex + 1] - 1]];
    outer_faces_.push_back(outer);
    faces_[outer].component = component;
    stack_.assign(1, outer);
    while (!stack_.empty()) {
        const Face& face = faces_[stack_.back()];
        stack_.pop_back();
        Half half = face.first;
        do {
            component_of_[from(half)] = component;
            Face& across = faces_[face_of_[half ^ 1]];
            if (across.component == none) {
                across.component = component;
                across.winding = face.winding - times(half);
                stack_.push_back(face_of_[half ^ 1]);
            }
            half = next_around_face(half);
            worker_.spend(half_work);
        } while (half != face.first);
    }
}

/// A component's smallest point may lie within a chain, if opposite contours have left no more of that contour. Its outer
/// face is the one that is walked clockwise.
void Arrangement::find_outer_faces() {
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
        face_points_.clear();
        append_points_of(faces_[f], face_points_);
        if (examine_ring(face_points_.data(), face_points_.size()).twice_area < 0) {
            outer_faces_[faces_[f].component] = f;
        }
    }
    for (Face& face : faces_) {
        const Face& outer = faces_[outer_faces_[face.component]];
        face.winding -= &face == &outer ? 0 : outer.winding;
    }
    for (const std::uint32_t f : outer_faces_) {
        faces_[f].winding = 0;
    }
}

/// All points but the last, and where the edges from there on come from unless `origins` is null.
void Arrangement::append(Half half, Vector<Point>& points, Vector<PointOrigin>* origins) {
    const Strand& strand = strand_of(half);
    const bool backwards = half % 2 == 1;
    for (std::uint32_t i = 0; i < strand.edges; ++i) {
        points.push_back(point_of(half, i));
        if (origins != nullptr) {
            const PointOrigin origin = snapped_->origin_of(strand, backwards ? strand.edges - 1 - i : i);
            origins->push_back(backwards ? turned(origin) : origin);
        }
    }
    worker_.spend(half_work + strand.edges);
}

void Arrangement::list_extents(Vector<Extent>& faces) {
    faces.assign(faces_.size(), {});
    for (Half half = 0; half < halves_.size(); half += 2) {
        Extent along;
        for (std::uint32_t i = 0; i <= strand_of(half).edges; ++i) {
            along.include(point_of(half, i));
        }
        faces[face_of_[half]].include(along);
        faces[face_of_[half + 1]].include(along);
        worker_.spend(half_work + strand_of(half).edges);
    }
}

void Arrangement::append_points_of(const Face& face, Vector<Point>& points) {
    Half half = face.first;
    do {
        append(half, points, nullptr);
        half = next_around_face(half);
    } while (half != face.first);
}

void Arrangement::trace(std::span<const std::uint8_t> filled, Vector<Path>& contours, Vector<Point>& points,
                        Vector<PointOrigin>* origins) {
    contour_of_.resize(halves_.size());
    worker_.ask();
    worker_.in_stretches(0, halves_.size(), scatter_work, [&](std::size_t begin, std::size_t end) {
        for (auto half = static_cast<Half>(begin); half < end; ++half) {
            contour_of_[half] = filled[face_of_[half]] > filled[face_of_[half ^ 1]] ? untraced : no_boundary;
        }
    });
    const std::size_t base = contours.size();
    Vector<End> first_ends(faces_.get_allocator());
    for (Half half = 0; half < halves_.size(); ++half) {
        if (contour_of_[half] == untraced) {
            const std::size_t first_point = points.size();
            std::uint32_t part = strand_of(half).part;
            first_ends.push_back(follow_boundary(half, static_cast<std::int64_t>(contours.size()), points, origins, part));
            Path& path = contours.emplace_back();
            path.item.count = static_cast<std::uint32_t>(points.size() - first_point);
            path.item.part = part;
            path.made = true;
        }
    }
    for (std::size_t c = base; c < contours.size(); ++c) {
        contours[c].touched = touched_at(static_cast<std::int64_t>(c), static_cast<std::int64_t>(base), first_ends);
    }
}

/// Returns the contour's first end at its smallest vertex, the vertex being none where a point within a chain is smaller.
/// `part`, the first's, becomes that of all.
Arrangement::End Arrangement::follow_boundary(Half first, std::int64_t contour, Vector<Point>& points,
                                              Vector<PointOrigin>* origins, std::uint32_t& part) {
    End smallest{none, none};
    const std::size_t begin = points.size();
    Half half = first;
    do {
        contour_of_[half] = contour;
        append(half, points, origins);
        part = part_of_both(part, strand_of(half).part);
        smallest = std::min({smallest, End{from(half), place_of_[half]}, End{to(half), place_of_[half ^ 1]}});
        half = next_around_face(half);
        while (!is_boundary(half)) {
            half = clockwise_of(half);
            worker_.spend(1);
        }
    } while (half != first);
    const Point lowest = snapped_->vertices()[smallest.vertex];
    const bool is_lowest = std::none_of(points.begin() + static_cast<std::ptrdiff_t>(begin), points.end(),
                                        [lowest](Point p) { return p < lowest; });
    return is_lowest ? smallest : End{none, none};
}

/// The contour that has the next end clockwise of the first one of `contour`. Contours that begin at the same vertex and are
/// met by a way past the left of it come after this one; the way then goes on from their first ends.
std::int64_t Arrangement::touched_at(std::int64_t contour, std::int64_t base,
                                     std::span<const End> first_ends) const noexcept {
    const End first = first_ends[static_cast<std::size_t>(contour - base)];
    if (first.vertex == none) {
        return -1;
    }
    const std::uint32_t begin = first_halves_[first.vertex];
    std::uint32_t place = first.place;
    bool past_left = false;
    while (true) {
        do {
            past_left = past_left || place == begin;
            place = place == begin ? first_halves_[first.vertex + 1] - 1 : place - 1;
        } while (!is_boundary(halves_[place]) && !is_boundary(halves_[place] ^ 1));
        const Half half = halves_[place];
        const std::int64_t other = contour_of_[is_boundary(half) ? half : half ^ 1];
        if (other == contour) {
            return -1;
        }
        const End others_first = first_ends[static_cast<std::size_t>(other - base)];
        if (!past_left || others_first.vertex != first.vertex) {
            return other;
        }
        place = others_first.place;
    }
}

}  // namespace lamella
