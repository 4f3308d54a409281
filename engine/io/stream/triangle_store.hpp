// The triangles that planes cut and that are not done with. On disk: SpillFile. In memory: first in the order in which they
// come, then in the lists of their first planes, where ranges of layers are cut from the lowest up.
//
//     unlisted    [ t7 t2 t9 t1 t4 | room ]
//     listed      [ swept | reaching | plane 42 | plane 43 | ... ]      those of the range below that reach beyond it
//                           a list of the next range's first plane
#pragma once

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/system/file.hpp"
#include "lamella/array.hpp"
#include "slicing/buckets/listed_triangles.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// How many triangles planes begin and end to cut: from these numbers ranges of layers are chosen. A difference array over k
/// planes: a triangle that planes first to last - 1 cut is counted at both.
class PlaneCounts {
public:
    explicit PlaneCounts(std::size_t planes = 0) : starting_(planes + 1), ended_(planes + 1) {}

    void add(PlaneIndex first, PlaneIndex last) noexcept {
        ++starting_[first];
        ++ended_[last];
    }
    /// Moves the counts of `other` here.
    void take(PlaneCounts& other) noexcept {
        for (std::size_t i = 0; i < starting_.size(); ++i) {
            starting_[i] += std::exchange(other.starting_[i], 0U);
            ended_[i] += std::exchange(other.ended_[i], 0U);
        }
    }

    std::size_t planes() const noexcept { return starting_.size() - 1; }
    /// Triangles that the plane is the first to cut.
    std::uint32_t starting(std::size_t plane) const noexcept { return starting_[plane]; }
    /// Triangles that the plane below it is the last to cut.
    std::uint32_t ended(std::size_t plane) const noexcept { return ended_[plane]; }
    /// Triangles that the plane cuts, and the one below it too. O(plane).
    std::uint64_t reaching_into(std::size_t plane) const noexcept {
        std::uint64_t reaching = 0;
        for (std::size_t p = 0; p < plane; ++p) {
            reaching += starting_[p];
            reaching -= ended_[p];
        }
        return reaching - ended_[plane];
    }
    /// Calls visit(plane, triangles) with how many each plane cuts.
    template <class Visit>
    void each_plane(Visit visit) const {
        std::uint64_t active = 0;
        for (std::size_t plane = 0; plane < planes(); ++plane) {
            active += starting_[plane];
            active -= ended_[plane];
            visit(plane, active);
        }
    }
    /// Triangles that planes cut, and how often: their segments.
    std::uint64_t all() const noexcept { return std::accumulate(starting_.begin(), starting_.end(), std::uint64_t{0}); }
    std::uint64_t segments() const noexcept {
        std::uint64_t segments = 0;
        each_plane([&](std::size_t, std::uint64_t active) { segments += active; });
        return segments;
    }

    /// The plane that cuts the most triangles.
    std::size_t widest() const noexcept {
        std::pair<std::uint64_t, std::size_t> widest;
        each_plane([&](std::size_t plane, std::uint64_t active) {
            widest = active > widest.first ? std::pair(active, plane) : widest;
        });
        return widest.second;
    }

private:
    std::vector<std::uint32_t> starting_;
    std::vector<std::uint32_t> ended_;
};

/// Records hold their first planes; planes are those of the whole.
class TriangleStore {
public:
    explicit TriangleStore(const Memory* memory) : triangles_(memory) {}

    /// Empties it and makes it hold up to `capacity` triangles. Throws std::bad_alloc.
    void reserve(std::size_t capacity) {
        clear();
        triangles_ = Array<CrossedTriangle>(triangles_.memory());  // never two at once
        triangles_.resize_discarding(capacity);
    }

    /// From any thread. Precondition: there is room.
    void append(std::span<const CrossedTriangle> some) noexcept {
        const std::size_t at = size_.fetch_add(some.size(), std::memory_order_relaxed);
        if (!some.empty()) {
            std::memcpy(triangles_.data() + at, some.data(), some.size_bytes());
        }
    }
    void clear() noexcept { size_ = 0; }

    std::size_t size() const noexcept { return size_.load(std::memory_order_relaxed); }
    std::size_t capacity() const noexcept { return triangles_.size(); }
    std::span<CrossedTriangle> triangles() noexcept { return triangles_.span().first(size()); }

    /// Lists what is kept by planes [begin, end). Precondition: it is, of the triangles that are counted, those that planes
    /// from `begin` on cut and that begin below `end`. O(size). Throws Stopped, std::bad_alloc.
    void list(const PlaneCounts& counts, PlaneIndex begin, PlaneIndex end, const Parallel& parallel) {
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

    /// The triangles that planes [begin, end) cut. Precondition: they are listed, and those below `begin` dropped.
    ListedTriangles listed(PlaneIndex begin, PlaneIndex end) noexcept {
        const std::size_t at = begin - first_listed_;
        const std::size_t planes = end - begin;
        return {triangles_, std::span(list_begin_).subspan(at, planes + 1), std::span(segments_).subspan(at, planes), begin};
    }

    /// These planes are swept: drops what none from `end` on cuts.
    void drop_swept(PlaneIndex begin, PlaneIndex end) noexcept {
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

    /// Triangles that are left begin at the front again, where more can be appended. `begin`: planes below it are dropped.
    void unlist(PlaneIndex begin) noexcept {
        const std::size_t first = begin_of(begin);
        const std::size_t left = size() - first;
        std::memmove(triangles_.data(), triangles_.data() + first, left * sizeof(CrossedTriangle));
        size_ = left;
    }

private:
    std::uint32_t& begin_of(PlaneIndex plane) noexcept { return list_begin_[plane - first_listed_]; }

    Array<CrossedTriangle> triangles_;
    std::atomic<std::size_t> size_ = 0;
    PlaneIndex first_listed_ = 0;
    std::vector<std::uint32_t> list_begin_;  ///< of the planes listed, and one more
    std::vector<std::uint32_t> segments_;    ///< the same: triangles that each plane cuts
};

/// Triangles that wait for their layers on disk.
///
///     file     run 0: | bin 0 | bin 1 | ... |   run 1: | bin 0 | bin 1 | ... |   ...
///
/// A run is what memory held when it was full; a bin, a range of layers that the triangles begin in. Every run has the same
/// bins, so that a range of layers is a few large pieces of the file.
class SpillFile {
public:
    /// A file in `folder` without a name, with bins that begin about equally many of the triangles counted. Throws Refused
    /// (unwritable_file).
    SpillFile(const std::filesystem::path& folder, const PlaneCounts& counts)
        : folder_(folder), bin_planes_(even_bins(counts)) {
        refuse_if_failed("made", file_.create_scratch(folder_));
    }

    /// Adds a run, sorted in place first. A triangle that begins below plane `done` counts as one that begins there. Throws
    /// Refused, Stopped.
    void write(std::span<CrossedTriangle> triangles, PlaneIndex done, const Parallel& parallel) {
        std::vector<std::uint32_t> list_begin(bin_planes_.back() - done + std::size_t{1});
        for (const CrossedTriangle& triangle : triangles) {
            ++list_begin[std::max(triangle.first, done) - done + std::size_t{1}];
        }
        std::partial_sum(list_begin.begin(), list_begin.end(), list_begin.begin());
        sort_into_lists(triangles, done, list_begin, parallel);
        std::vector<std::uint64_t>& bin_begin = runs_.emplace_back();
        for (const PlaneIndex begin : bin_planes_) {
            bin_begin.push_back(triangles_ + list_begin[std::max(begin, done) - done]);
        }
        parallel.run((triangles.size() + write_piece - 1) / write_piece, [&](std::size_t i, int) {
            const std::size_t first = i * write_piece;
            const std::size_t count = std::min(write_piece, triangles.size() - first);
            refuse_if_failed("written", file_.write_at(std::as_bytes(triangles.subspan(first, count)),
                                                       (triangles_ + first) * sizeof(CrossedTriangle)));
        });
        triangles_ += triangles.size();
    }

    /// Appends to `store` all triangles that begin in planes [begin, end), by the same rule. `piece`: how many to read at
    /// once. Throws Refused, Stopped.
    void load(PlaneIndex begin, PlaneIndex end, PlaneIndex done, std::size_t piece, const Parallel& parallel,
              TriangleStore& store) {
        struct Piece {
            std::uint64_t at;
            std::size_t count;
        };
        const auto bin_of = [this](PlaneIndex plane) {
            return static_cast<std::size_t>(std::upper_bound(bin_planes_.begin(), bin_planes_.end(), plane) -
                                            bin_planes_.begin() - 1);
        };
        const std::size_t first_bin = bin_of(begin);
        const std::size_t last_bin = bin_of(end - 1);
        std::vector<Piece> pieces;
        for (const std::vector<std::uint64_t>& bin_begin : runs_) {
            for (std::uint64_t at = bin_begin[first_bin], stop = bin_begin[last_bin + 1]; at < stop; at += piece) {
                pieces.push_back({at, static_cast<std::size_t>(std::min<std::uint64_t>(piece, stop - at))});
            }
        }
        buffers_.resize(static_cast<std::size_t>(parallel.threads()));
        parallel.run(pieces.size(), [&](std::size_t i, int worker) {
            Array<CrossedTriangle>& buffer = buffers_[static_cast<std::size_t>(worker)];
            buffer.resize_discarding(piece);
            const std::span<CrossedTriangle> some(buffer.data(), pieces[i].count);
            refuse_if_failed("read", file_.read_at(std::as_writable_bytes(some), pieces[i].at * sizeof(CrossedTriangle)));
            const auto wanted = std::partition(some.begin(), some.end(), [&](const CrossedTriangle& t) {
                const PlaneIndex first = std::max(t.first, done);
                return first >= begin && first < end;
            });
            store.append(some.first(static_cast<std::size_t>(wanted - some.begin())));
        });
    }

    std::uint64_t bytes() const noexcept { return triangles_ * sizeof(CrossedTriangle); }

private:
    static constexpr std::size_t write_piece = std::size_t{1} << 15;  // triangles

    /// Where each of some bins begins if all begin about equally many triangles.
    static std::vector<PlaneIndex> even_bins(const PlaneCounts& counts) {
        constexpr std::uint64_t bins = 256;
        const std::uint64_t all = counts.all();
        std::vector<PlaneIndex> begins = {0};
        std::uint64_t before = 0;
        for (std::size_t plane = 0; plane < counts.planes(); ++plane) {
            if (before * bins >= all * begins.size() && begins.back() < plane) {
                begins.push_back(static_cast<PlaneIndex>(plane));
            }
            before += counts.starting(plane);
        }
        begins.push_back(static_cast<PlaneIndex>(counts.planes()));
        return begins;
    }

    void refuse_if_failed(const char* what, int failure) const {
        if (failure != 0) {
            throw Refused{{ErrorCode::unwritable_file, "a temporary file in '" + path_text(folder_) + "' cannot be " + what +
                                                           ": " + system_message(failure)}};
        }
    }

    std::filesystem::path folder_;
    File file_;
    std::vector<PlaneIndex> bin_planes_;            ///< first plane of each bin, and one past the last
    std::vector<std::vector<std::uint64_t>> runs_;  ///< where each bin begins, in triangles of the file, and one more
    std::vector<Array<CrossedTriangle>> buffers_;   ///< by thread
    std::uint64_t triangles_ = 0;
};

}  // namespace lamella
