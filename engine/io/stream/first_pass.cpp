#include "io/stream/first_pass.hpp"

#include "io/text/text.hpp"

namespace lamella {

namespace {

constexpr double share_of_progress = 0.3;

/// Scratch with which a thread measures chunks.
struct Measurer {
    explicit Measurer(std::size_t buffer_bytes) : bytes(buffer_bytes), one({.threads = 1}), table(nullptr) {}

    bool any_near() const {
        return std::any_of(table.blocks.begin(), table.blocks.end(), [](const TriangleBlock& block) { return block.near; });
    }

    std::vector<std::byte> bytes;
    Parallel one;
    BlockTable table;
};

/// Says the triangle's number in the file, not in the chunk, which the message begins with.
Error at_file_position(Error error, std::uint64_t first) {
    const std::string own = "triangle " + std::to_string(error.triangle);
    if (error.triangle >= 0 && error.message.starts_with(own)) {
        error.triangle += static_cast<std::int64_t>(first);
        error.message.replace(0, own.size(), "triangle " + std::to_string(error.triangle));
    }
    return error;
}

/// The box of all chunks, each of which learns the least of those that come after it.
Bounds united(std::span<const Bounds> each, std::span<FileChunk> chunks) {
    Bounds all = Bounds::empty();
    for (const Bounds& own : each) {
        all.add(own);
    }
    double low = all.max_mm[2];
    std::for_each(chunks.rbegin(), chunks.rend(), [&low](FileChunk& chunk) {
        low = std::min(low, chunk.low_mm);
        chunk.low_from_here_mm = low;
    });
    return all;
}

}  // namespace

FileBox measure_file(const TriangleFile& file, std::span<const std::byte> resident, const Placing& placing, double asked_mm,
                     std::size_t chunk_triangles, const Parallel& parallel) {
    FileBox box{};
    box.chunks.resize((file.triangles() + chunk_triangles - 1) / chunk_triangles);
    std::vector<Bounds> each(box.chunks.size());
    std::vector<std::unique_ptr<Measurer>> measurers(static_cast<std::size_t>(parallel.threads()));
    parse_pieces<Refused>(box.chunks.size(), parallel, [&](std::size_t chunk, int worker) {
        auto& measurer = measurers[static_cast<std::size_t>(worker)];
        if (measurer == nullptr) {
            measurer = std::make_unique<Measurer>(chunk_triangles * file.buffer_bytes());
        }
        const std::uint64_t first = std::uint64_t{chunk} * chunk_triangles;
        const std::size_t count = std::min<std::uint64_t>(chunk_triangles, file.triangles() - first);
        const MeshView view = file.read(first, count, measurer->bytes, resident);
        const Result<Bounds> bounds = measure_bounds(view, placing, asked_mm, measurer->one, measurer->table);
        if (!bounds) {
            file.refuse(at_file_position(bounds.error(), first));
        }
        each[chunk] = *bounds;
        box.chunks[chunk] = {each[chunk].min_mm[2], each[chunk].max_mm[2], 0, measurer->any_near()};
        parallel.reach(share_of_progress * static_cast<double>(chunk) / static_cast<double>(box.chunks.size()));
    });
    box.bounds = united(each, box.chunks);
    return box;
}

}  // namespace lamella
