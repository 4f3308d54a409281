#include "io/stream/spill_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "base/guard.hpp"
#include "lamella/error.hpp"

namespace lamella {

namespace {

/// Opened and without a name at once, so that no end of the process leaves it behind.
int open_unnamed(const std::filesystem::path& folder) {
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

bool write_fully(int descriptor, std::span<const CrossedTriangle> triangles, std::uint64_t at) {
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

bool read_fully(int descriptor, std::span<CrossedTriangle> into, std::uint64_t at) {
    auto* to = reinterpret_cast<char*>(into.data());
    std::size_t left = into.size_bytes();
    std::uint64_t offset = at * sizeof(CrossedTriangle);
    while (left > 0) {
        const ssize_t done = ::pread(descriptor, to, left, static_cast<off_t>(offset));
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done <= 0) {
            return false;
        }
        to += done;
        left -= static_cast<std::size_t>(done);
        offset += static_cast<std::uint64_t>(done);
    }
    return true;
}

/// Where each of `bins` begins if all begin about equally many triangles.
std::vector<PlaneIndex> even_bins(const PlaneCounts& counts, std::size_t bins) {
    std::uint64_t all = 0;
    for (std::size_t plane = 0; plane < counts.planes(); ++plane) {
        all += counts.starting(plane);
    }
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

}  // namespace

SpillFile::SpillFile(const std::filesystem::path& folder, const PlaneCounts& counts, std::size_t bins,
                     std::size_t buffer_bytes)
    : folder_(folder), buffer_bytes_(buffer_bytes), bin_planes_(even_bins(counts, bins)), bin_of_(counts.planes()) {
    for (std::size_t bin = 0; bin < this->bins(); ++bin) {
        std::fill(bin_of_.begin() + bin_planes_[bin], bin_of_.begin() + bin_planes_[bin + 1],
                  static_cast<std::uint16_t>(bin));
    }
    descriptor_ = open_unnamed(folder_);
    if (descriptor_ < 0) {
        throw Refused{failed("made")};
    }
}

SpillFile::~SpillFile() {
    if (descriptor_ >= 0) {
        ::close(descriptor_);
    }
}

Error SpillFile::failed(const char* what) const {
    return {ErrorCode::unwritable_file, "a temporary file in '" + folder_.string() + "' cannot be " + what + ": " +
                                            std::generic_category().message(errno)};
}

/// One thread's share of a run: triangles go to their bins by way of a buffer each.
class SpillFile::Writer {
public:
    /// `buffers` is kept from run to run: fresh pages would cost more than the copying.
    Writer(const SpillFile& spill, std::vector<std::uint64_t> next, std::size_t buffer_triangles,
           Array<CrossedTriangle>& buffers)
        : spill_(spill), next_(std::move(next)), used_(next_.size()), room_(buffer_triangles), buffers_(buffers) {
        buffers_.resize_discarding(next_.size() * room_);
    }

    void add(std::size_t bin, const CrossedTriangle& triangle) {
        buffers_[bin * room_ + used_[bin]++] = triangle;
        if (used_[bin] == room_) {
            flush(bin);
        }
    }
    void finish() {
        for (std::size_t bin = 0; bin < used_.size(); ++bin) {
            flush(bin);
        }
    }

private:
    void flush(std::size_t bin) {
        const std::size_t count = std::exchange(used_[bin], 0);
        if (!write_fully(spill_.descriptor_, {buffers_.data() + bin * room_, count}, next_[bin])) {
            throw Refused{spill_.failed("written")};
        }
        next_[bin] += count;
    }

    const SpillFile& spill_;
    std::vector<std::uint64_t> next_;  // by bin: where the next triangle goes
    std::vector<std::size_t> used_;
    std::size_t room_;
    Array<CrossedTriangle>& buffers_;
};

void SpillFile::write(std::span<const CrossedTriangle> triangles, PlaneIndex done, const Parallel& parallel) {
    const auto parts = static_cast<std::size_t>(parallel.threads());
    const auto part_begin = [&](std::size_t part) { return triangles.size() * part / parts; };
    const auto bin_of = [&](const CrossedTriangle& t) { return bin_of_[std::max(t.first, done)]; };
    std::vector<std::vector<std::uint64_t>> next(parts, std::vector<std::uint64_t>(bins()));
    parallel.run(parts, [&](std::size_t part, int) {
        for (std::size_t i = part_begin(part); i < part_begin(part + 1); ++i) {
            ++next[part][bin_of(triangles[i])];
        }
    });
    Run& run = runs_.emplace_back();
    for (std::size_t bin = 0; bin < bins(); ++bin) {
        run.bin_begin.push_back(triangles_);
        for (std::vector<std::uint64_t>& own : next) {
            triangles_ += std::exchange(own[bin], triangles_);
        }
    }
    run.bin_begin.push_back(triangles_);
    const std::size_t room = std::clamp<std::size_t>(buffer_bytes_ / (parts * bins() * sizeof(CrossedTriangle)), 1, 1024);
    buffers_.resize(parts);
    parallel.run(parts, [&](std::size_t part, int) {
        Writer writer(*this, std::move(next[part]), room, buffers_[part]);
        for (std::size_t i = part_begin(part); i < part_begin(part + 1); ++i) {
            writer.add(bin_of(triangles[i]), triangles[i]);
        }
        writer.finish();
    });
}

void SpillFile::load(PlaneIndex begin, PlaneIndex end, PlaneIndex done, std::size_t piece, const Parallel& parallel,
                     TriangleStore& store) {
    struct Piece {
        std::uint64_t at;
        std::size_t count;
    };
    std::vector<Piece> pieces;
    const std::size_t first_bin = bin_of_[begin];
    const std::size_t last_bin = bin_of_[end - 1];
    for (const Run& run : runs_) {
        for (std::uint64_t at = run.bin_begin[first_bin], stop = run.bin_begin[last_bin + 1]; at < stop; at += piece) {
            pieces.push_back({at, static_cast<std::size_t>(std::min<std::uint64_t>(piece, stop - at))});
        }
    }
    buffers_.resize(static_cast<std::size_t>(parallel.threads()));
    parallel.run(pieces.size(), [&](std::size_t i, int worker) {
        Array<CrossedTriangle>& buffer = buffers_[static_cast<std::size_t>(worker)];
        buffer.resize_discarding(piece);
        const std::span<CrossedTriangle> some(buffer.data(), pieces[i].count);
        if (!read_fully(descriptor_, some, pieces[i].at)) {
            throw Refused{failed("read")};
        }
        const auto wanted = std::partition(some.begin(), some.end(), [&](const CrossedTriangle& t) {
            const PlaneIndex first = std::max(t.first, done);
            return first >= begin && first < end;
        });
        store.append(some.first(static_cast<std::size_t>(wanted - some.begin())));
    });
}

}  // namespace lamella
