#include "io/stream/chunk_scan.hpp"

#include "io/text/text.hpp"

namespace lamella {

namespace {

constexpr double share_of_progress = 0.3;

/// Says the triangle's number in the file, not in the chunk, which the message begins with.
Error at_file_position(Error error, std::uint64_t first) {
    const std::string own = "triangle " + std::to_string(error.triangle);
    if (error.triangle >= 0 && error.message.starts_with(own)) {
        error.triangle += static_cast<std::int64_t>(first);
        error.message.replace(0, own.size(), "triangle " + std::to_string(error.triangle));
    }
    return error;
}

}  // namespace

FileBox measure_file(const TriangleFile& file, std::span<const std::byte> resident, const Placing& placing, double asked_mm,
                     std::size_t chunk_triangles, const Parallel& parallel) {
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

}  // namespace lamella
