#include "io/stream/file_box.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/guard.hpp"

namespace lamella {

namespace {

constexpr double share_of_progress = 0.3;

/// What a thread needs to measure chunks.
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

/// The failure of the first chunk, whichever thread comes first.
class FirstFailure {
public:
    bool is_before(std::size_t chunk) const noexcept { return chunk > chunk_.load(std::memory_order_relaxed); }

    void note(std::size_t chunk, Error error) {
        const std::lock_guard lock(mutex_);
        if (chunk < chunk_) {
            chunk_ = chunk;
            error_ = std::move(error);
        }
    }
    const std::optional<Error>& error() const noexcept { return error_; }

private:
    std::mutex mutex_;
    std::atomic<std::size_t> chunk_ = std::numeric_limits<std::size_t>::max();
    std::optional<Error> error_;
};

/// Of all chunks; each learns the least of those that come after it.
Bounds united(std::span<const Bounds> each, std::span<FileChunk> chunks) {
    Bounds all = each.front();
    for (const Bounds& own : each) {
        for (int axis = 0; axis < 3; ++axis) {
            all.min_mm[axis] = std::min(all.min_mm[axis], own.min_mm[axis]);
            all.max_mm[axis] = std::max(all.max_mm[axis], own.max_mm[axis]);
        }
    }
    double low = all.max_mm[2];
    std::for_each(chunks.rbegin(), chunks.rend(), [&low](FileChunk& chunk) {
        low = std::min(low, chunk.low_mm);
        chunk.low_from_here_mm = low;
    });
    return all;
}

}  // namespace

Result<FileBox> measure_file(const TriangleFile& file, const Transform& transform, double asked_mm,
                             std::size_t chunk_triangles, const Parallel& parallel, ProgressMeter& progress) {
    FileBox box{};
    box.chunks.resize((file.triangles() + chunk_triangles - 1) / chunk_triangles);
    std::vector<Bounds> each(box.chunks.size());
    std::vector<std::unique_ptr<Measurer>> measurers(static_cast<std::size_t>(parallel.threads()));
    FirstFailure failure;
    parallel.run(box.chunks.size(), [&](std::size_t chunk, int worker) {
        if (failure.is_before(chunk)) {
            return;
        }
        auto& measurer = measurers[static_cast<std::size_t>(worker)];
        if (measurer == nullptr) {
            measurer = std::make_unique<Measurer>(chunk_triangles * file.buffer_bytes());
        }
        const std::uint64_t first = std::uint64_t{chunk} * chunk_triangles;
        const std::size_t count = std::min<std::uint64_t>(chunk_triangles, file.triangles() - first);
        try {
            const MeshView view = file.read(first, count, measurer->bytes);
            const Result<Bounds> bounds = measure_bounds(view, transform, asked_mm, measurer->one, measurer->table);
            if (!bounds) {
                throw Refused{file.named(at_file_position(bounds.error(), first))};
            }
            each[chunk] = *bounds;
        } catch (Refused& refused) {
            return failure.note(chunk, std::move(refused.error));
        }
        box.chunks[chunk] = {each[chunk].min_mm[2], each[chunk].max_mm[2], 0, measurer->any_near()};
        progress.reach(share_of_progress * static_cast<double>(chunk) / static_cast<double>(box.chunks.size()));
    });
    if (failure.error()) {
        return *failure.error();
    }
    box.bounds = united(each, box.chunks);
    return box;
}

}  // namespace lamella
