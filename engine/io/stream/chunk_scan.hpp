// Both passes over a file of triangles, chunk by chunk: its box, and then which planes cut each triangle.
#pragma once

#include <algorithm>
#include <bit>
#include <memory>
#include <string>
#include <vector>

#include "base/guard.hpp"
#include "io/stream/triangle_file.hpp"
#include "io/stream/triangle_store.hpp"
#include "io/text/text.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

/// So many triangles of the file as are read at once. Heights are those after the transform.
struct FileChunk {
    double low_mm;
    double high_mm;
    double low_from_here_mm;  ///< the least of this chunk and of all that come after it
    bool near;                ///< some triangle may have two equal vertices on the grid
};

struct FileBox {
    Bounds bounds;
    std::vector<FileChunk> chunks;
};

/// Reads and measures chunks on one thread.
class ChunkReader {
public:
    ChunkReader(const TriangleFile& file, std::span<const std::byte> resident, std::size_t chunk_triangles)
        : file_(file),
          resident_(resident),
          chunk_triangles_(chunk_triangles),
          bytes_(chunk_triangles * file.buffer_bytes()),
          one_({.threads = 1}) {}

    /// The triangles of a chunk, until the next call. Throws Refused.
    MeshView read(std::size_t chunk) {
        const std::uint64_t first = std::uint64_t{chunk} * chunk_triangles_;
        const std::size_t count = std::min<std::uint64_t>(chunk_triangles_, file_.triangles() - first);
        return file_.read(first, count, bytes_, resident_);
    }

    Result<Bounds> measure(const MeshView& chunk, const Placing& placing, double unit_mm) {
        return measure_bounds(chunk, placing, unit_mm, one_, table_);
    }
    /// The blocks of the chunk measured last.
    const BlockTable& table() const noexcept { return table_; }

private:
    const TriangleFile& file_;
    std::span<const std::byte> resident_;
    std::size_t chunk_triangles_;
    std::vector<std::byte> bytes_;
    Parallel one_;
    BlockTable table_{nullptr};
};

/// Says the triangle's number in the file, not in the chunk, which the message begins with.
inline Error at_file_position(Error error, std::uint64_t first) {
    const std::string own = "triangle " + std::to_string(error.triangle);
    if (error.triangle >= 0 && error.message.starts_with(own)) {
        error.triangle += static_cast<std::int64_t>(first);
        error.message.replace(0, own.size(), "triangle " + std::to_string(error.triangle));
    }
    return error;
}

/// The first pass: reads all of `file`, in chunks of `chunk_triangles`. `asked_mm`: the grid unit asked for, or 0. Throws
/// Refused, with the file's name: bad_coordinate (with the triangle), and as TriangleFile::read(); Stopped, std::bad_alloc.
inline FileBox measure_file(const TriangleFile& file, std::span<const std::byte> resident, const Placing& placing,
                            double asked_mm, std::size_t chunk_triangles, const Parallel& parallel) {
    constexpr double share_of_progress = 0.3;
    FileBox box{};
    box.chunks.resize((file.triangles() + chunk_triangles - 1) / chunk_triangles);
    std::vector<Bounds> each(box.chunks.size());
    std::vector<std::unique_ptr<ChunkReader>> readers(static_cast<std::size_t>(parallel.threads()));
    parse_pieces<Refused>(box.chunks.size(), parallel, [&](std::size_t chunk, int worker) {
        auto& reader = readers[static_cast<std::size_t>(worker)];
        if (reader == nullptr) {
            reader = std::make_unique<ChunkReader>(file, resident, chunk_triangles);
        }
        const Result<Bounds> bounds = reader->measure(reader->read(chunk), placing, asked_mm);
        if (!bounds) {
            file.refuse(at_file_position(bounds.error(), std::uint64_t{chunk} * chunk_triangles));
        }
        each[chunk] = *bounds;
        const Array<TriangleBlock>& blocks = reader->table().blocks;
        const bool near = std::any_of(blocks.begin(), blocks.end(), [](const TriangleBlock& block) { return block.near; });
        box.chunks[chunk] = {bounds->min_mm[2], bounds->max_mm[2], 0, near};
        parallel.reach(share_of_progress * static_cast<double>(chunk) / static_cast<double>(box.chunks.size()));
    });
    box.bounds = Bounds::empty();
    for (const Bounds& own : each) {
        box.bounds.add(own);
    }
    double low = box.bounds.max_mm[2];
    std::for_each(box.chunks.rbegin(), box.chunks.rend(), [&low](FileChunk& chunk) {
        low = std::min(low, chunk.low_mm);
        chunk.low_from_here_mm = low;
    });
    return box;
}

/// The second pass, as one thread works on it: which planes cut each triangle of a chunk. Gives what count_crossings() gives
/// for the whole mesh, chunk by chunk.
class ChunkScan {
public:
    ChunkScan(const TriangleFile& file, std::span<const std::byte> resident, std::size_t chunk_triangles,
              const Placing& placing, double unit_mm, const PlaneSet& planes, InstructionSet instructions)
        : reader_(file, resident, chunk_triangles),
          placing_(placing),
          unit_mm_(unit_mm),
          planes_(planes),
          instructions_(instructions),
          found_(chunk_triangles),
          counts_(planes.size()) {}

    /// The triangles of a chunk that planes cut, until the next call. Adds to counts() and degenerate(). Without `near` none
    /// is degenerate. Throws Refused.
    std::span<const CrossedTriangle> scan(std::size_t index, bool near) {
        found_count_ = 0;
        const MeshView chunk = reader_.read(index);
        const SoupScan soup(chunk, placing_, unit_mm_, planes_, instructions_);
        // Else blocks that lie between planes would be left out, which takes longer to find than to read them.
        measured_ = near || !soup.usable() || chunk.triangle_count % block_triangles != 0;
        if (measured_) {
            require(reader_.measure(chunk, placing_, unit_mm_));  // refused where the file has changed meanwhile
        }
        with_reader(chunk, placing_, unit_mm_, [&](const auto& read) {
            for (std::size_t begin = 0; begin < chunk.triangle_count; begin += block_triangles) {
                scan_block(read, soup, begin, std::min<std::size_t>(begin + block_triangles, chunk.triangle_count));
            }
        });
        const std::span<const CrossedTriangle> found = std::span(found_).first(found_count_);
        for (const CrossedTriangle& triangle : found) {
            counts_.add(triangle.first, triangle.last);
        }
        return found;
    }

    PlaneCounts& counts() noexcept { return counts_; }
    std::uint64_t degenerate() const noexcept { return degenerate_; }

private:
    template <class Reader>
    void scan_block(const Reader& read, const SoupScan& soup, std::size_t begin, std::size_t end) {
        const std::size_t block = begin / block_triangles;
        const bool may_be_degenerate = measured_ && reader_.table().may_be_degenerate(block, unit_mm_);
        if (measured_ && !may_be_degenerate && lies_between_planes(reader_.table().blocks[block], unit_mm_, planes_)) {
            return;
        }
        std::uint64_t degenerate = 0;
        for (std::size_t t = begin; may_be_degenerate && t < end; ++t) {
            degenerate |= std::uint64_t{is_degenerate(read(t))} << (t - begin);
        }
        degenerate_ += static_cast<std::uint64_t>(std::popcount(degenerate));
        if (soup.usable() && end - begin == block_triangles) {
            found_count_ += soup.append(begin, ~degenerate, found_.data() + found_count_);
            return;
        }
        for (std::size_t t = begin; t < end; ++t) {
            if ((degenerate >> (t - begin) & 1) == 0) {
                keep(read(t));
            }
        }
    }

    /// If planes cut it.
    void keep(const GridTriangle& vertices) {
        CrossedTriangle triangle = order_by_height(vertices, 0);
        triangle.first = planes_.first_above(triangle.lower.z);
        if (planes_.z(triangle.first) < triangle.upper.z) {
            triangle.middle_and_source |= planes_.first_above(triangle.middle.z);
            triangle.last = planes_.first_above(triangle.upper.z);
            found_[found_count_++] = triangle;
        }
    }

    ChunkReader reader_;
    Placing placing_;
    double unit_mm_;
    const PlaneSet& planes_;
    InstructionSet instructions_;
    std::vector<CrossedTriangle> found_;
    std::size_t found_count_ = 0;
    bool measured_ = false;  ///< the chunk at hand
    PlaneCounts counts_;
    std::uint64_t degenerate_ = 0;
};

}  // namespace lamella
