#include "io/stream/triangle_store.hpp"

#include <algorithm>
#include <cassert>

namespace lamella {

std::size_t PlaneCounts::widest() const noexcept {
    std::uint64_t active = 0;
    std::uint64_t most = 0;
    std::size_t widest = 0;
    for (std::size_t plane = 0; plane < planes(); ++plane) {
        active += starting_[plane];
        active -= ended_[plane];
        widest = active > most ? plane : widest;
        most = std::max(most, active);
    }
    return widest;
}

void TriangleStore::list(const PlaneCounts& counts, PlaneIndex begin, PlaneIndex end, const Parallel& parallel) {
    first_listed_ = begin;
    list_begin_.assign(std::size_t{end} - begin + 1, 0);
    segments_.assign(std::size_t{end} - begin + 1, 0);
    std::uint64_t reaching = counts.reaching_into(begin);
    std::uint64_t active = counts.reaching_into(begin);
    std::uint64_t next = 0;
    for (PlaneIndex plane = begin; plane < end; ++plane) {
        active += counts.starting(plane);
        active -= plane > begin ? counts.ended(plane) : 0;
        begin_of(plane) = static_cast<std::uint32_t>(next);
        segments_[plane - begin] = static_cast<std::uint32_t>(active);
        next += counts.starting(plane) + reaching;
        reaching = 0;
    }
    begin_of(end) = static_cast<std::uint32_t>(next);
    segments_[end - begin] = begin < end ? static_cast<std::uint32_t>(active - counts.ended(end)) : 0;
    assert(next == size() || begin == end);
    if (begin < end) {
        sort_into_lists(triangles_.span().first(size()), begin, list_begin_, parallel);
    }
}

ListedTriangles TriangleStore::listed(PlaneIndex begin, PlaneIndex end) noexcept {
    const std::size_t at = begin - first_listed_;
    const std::size_t planes = end - begin;
    return {triangles_, std::span(list_begin_).subspan(at, planes + 1), std::span(segments_).subspan(at, planes), begin};
}

void TriangleStore::drop_swept(PlaneIndex begin, PlaneIndex end) noexcept {
    const std::size_t next = end - first_listed_;
    std::uint32_t to = begin_of(end);
    const std::uint32_t own = next + 1 < list_begin_.size() ? begin_of(end + 1) - to : 0;
    // The plane cuts so many that begin below it. Most of them lie near the end.
    for (std::uint32_t left = segments_[next] - own, i = to; left > 0;) {
        assert(i > begin_of(begin));
        CrossedTriangle record = triangles_[--i];
        if (record.last + begin > end) {
            record.last += begin;  // planes counted from the range's first
            record.middle_and_source += begin;
            triangles_[--to] = record;
            --left;
        }
    }
    begin_of(end) = to;
}

void TriangleStore::unlist(PlaneIndex begin) noexcept {
    const std::size_t first = begin_of(begin);
    const std::size_t left = size() - first;
    std::memmove(triangles_.data(), triangles_.data() + first, left * sizeof(CrossedTriangle));
    size_ = left;
}

}  // namespace lamella
