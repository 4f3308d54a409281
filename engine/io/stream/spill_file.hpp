// Triangles of a slice within a budget of memory that do not fit into it.
#pragma once

#include <cerrno>
#include <cstdlib>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "base/guard.hpp"
#include "io/read/input_file.hpp"
#include "io/stream/triangle_store.hpp"

namespace lamella {

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
        descriptor_ = open_unnamed(folder_);
        if (descriptor_ < 0) {
            throw Refused{failed("made")};
        }
    }

    ~SpillFile() {
        if (descriptor_ >= 0) {
            ::close(descriptor_);
        }
    }

    SpillFile(const SpillFile&) = delete;
    SpillFile& operator=(const SpillFile&) = delete;

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
            if (!write_fully(descriptor_, triangles.subspan(first, count), triangles_ + first)) {
                throw Refused{failed("written")};
            }
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
            if (read_fully(descriptor_, std::as_writable_bytes(some), pieces[i].at * sizeof(CrossedTriangle)) != 0) {
                throw Refused{failed("read")};
            }
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

    /// Opened and without a name at once, so that no end of the process leaves it behind.
    static int open_unnamed(const std::filesystem::path& folder) {
#ifdef O_TMPFILE
        if (const int descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600); descriptor >= 0) {
            return descriptor;
        }
#endif
        std::string name = (folder / ".lamella-XXXXXX").string();
        const int descriptor = ::mkstemp(name.data());
        if (descriptor >= 0) {
            (void)::unlink(name.c_str());
        }
        return descriptor;
    }

    static bool write_fully(int descriptor, std::span<const CrossedTriangle> triangles, std::uint64_t at) {
        const auto* from = reinterpret_cast<const char*>(triangles.data());
        std::size_t left = triangles.size_bytes();
        std::uint64_t offset = at * sizeof(CrossedTriangle);
        while (left > 0) {
            const ssize_t done = ::pwrite(descriptor, from, left, static_cast<off_t>(offset));
            if (done < 0 && errno == EINTR) {
                continue;
            }
            if (done <= 0) {
                return false;
            }
            from += done;
            left -= static_cast<std::size_t>(done);
            offset += static_cast<std::uint64_t>(done);
        }
        return true;
    }

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

    Error failed(const char* what) const {
        return {ErrorCode::unwritable_file, "a temporary file in '" + folder_.string() + "' cannot be " + what + ": " +
                                                std::generic_category().message(errno)};
    }

    std::filesystem::path folder_;
    int descriptor_ = -1;
    std::vector<PlaneIndex> bin_planes_;            ///< first plane of each bin, and one past the last
    std::vector<std::vector<std::uint64_t>> runs_;  ///< where each bin begins, in triangles of the file, and one more
    std::vector<Array<CrossedTriangle>> buffers_;   ///< by thread
    std::uint64_t triangles_ = 0;
};

}  // namespace lamella
