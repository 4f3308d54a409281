#include "io/stream/file_box.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "base/guard.hpp"

namespace lamella {

namespace {

constexpr double share_of_progress = 0.3;

/// What a thread needs to measure chunks.
struct Measurer {
    explicit Measurer(std::size_t buffer_bytes) : bytes(buffer_bytes), one({.threads = 1}), table(nullptr) {}

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

class FilePass {
public:
    FilePass(const TriangleFile& file, const Transform& transform, double asked_mm, std::size_t chunk_triangles,
             const Parallel& parallel)
        : file_(file),
          transform_(transform),
          asked_mm_(asked_mm),
          chunk_(chunk_triangles),
          measurers_(static_cast<std::size_t>(parallel.threads())) {
        box_.chunks.resize((file.triangles() + chunk_ - 1) / chunk_);
    }

    Result<FileBox> run(const Parallel& parallel, ProgressMeter& progress) {
        bounds_.resize(box_.chunks.size());
        parallel.run(box_.chunks.size(), [&](std::size_t chunk, int worker) {
            try {
                measure(chunk, worker);
            } catch (Refused& refused) {
                note(chunk, std::move(refused.error));
            }
            progress.reach(share_of_progress * static_cast<double>(chunk) / static_cast<double>(box_.chunks.size()));
        });
        if (failure_) {
            return *failure_;
        }
        unite();
        return std::move(box_);
    }

private:
    void measure(std::size_t chunk, int worker) {
        auto& measurer = measurers_[static_cast<std::size_t>(worker)];
        if (chunk > failed_chunk_.load(std::memory_order_relaxed)) {
            return;
        }
        if (measurer == nullptr) {
            measurer = std::make_unique<Measurer>(chunk_ * file_.buffer_bytes());
        }
        const std::uint64_t first = std::uint64_t{chunk} * chunk_;
        const std::size_t count = std::min<std::uint64_t>(chunk_, file_.triangles() - first);
        const MeshView view = file_.read(first, count, measurer->bytes);
        const Result<Bounds> bounds = measure_bounds(view, transform_, asked_mm_, measurer->one, measurer->table);
        if (!bounds) {
            note(chunk, file_.named(at_file_position(bounds.error(), first)));
            return;
        }
        const auto& blocks = measurer->table.blocks;
        bounds_[chunk] = *bounds;
        box_.chunks[chunk] = {bounds->min_mm[2], bounds->max_mm[2], 0,
                              std::any_of(blocks.begin(), blocks.end(), [](const TriangleBlock& b) { return b.near; })};
    }

    /// The failure of the first chunk stands, whichever thread comes first.
    void note(std::size_t chunk, Error error) {
        const std::lock_guard lock(mutex_);
        if (chunk < failed_chunk_) {
            failed_chunk_ = chunk;
            failure_ = std::move(error);
        }
    }

    void unite() {
        Bounds& all = box_.bounds = bounds_.front();
        for (const Bounds& own : bounds_) {
            for (int axis = 0; axis < 3; ++axis) {
                all.min_mm[axis] = std::min(all.min_mm[axis], own.min_mm[axis]);
                all.max_mm[axis] = std::max(all.max_mm[axis], own.max_mm[axis]);
            }
        }
        double low = all.max_mm[2];
        std::for_each(box_.chunks.rbegin(), box_.chunks.rend(), [&low](FileChunk& chunk) {
            low = std::min(low, chunk.low_mm);
            chunk.low_from_here_mm = low;
        });
    }

    const TriangleFile& file_;
    const Transform& transform_;
    double asked_mm_;
    std::size_t chunk_;
    FileBox box_{};
    std::vector<Bounds> bounds_;
    std::vector<std::unique_ptr<Measurer>> measurers_;
    std::mutex mutex_;
    std::atomic<std::size_t> failed_chunk_ = std::numeric_limits<std::size_t>::max();
    std::optional<Error> failure_;
};

}  // namespace

Result<FileBox> measure_file(const TriangleFile& file, const Transform& transform, double asked_mm,
                             std::size_t chunk_triangles, const Parallel& parallel, ProgressMeter& progress) {
    return FilePass(file, transform, asked_mm, chunk_triangles, parallel).run(parallel, progress);
}

}  // namespace lamella
