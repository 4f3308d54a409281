// One call of slice_file(), as the list of its stages.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/progress_meter.hpp"
#include "io/stream/chunk_scan.hpp"
#include "io/stream/file_box.hpp"
#include "io/stream/memory_model.hpp"
#include "io/stream/spill_file.hpp"
#include "io/stream/triangle_file.hpp"
#include "lamella/slice_file.hpp"
#include "slicing/planes/shared_frame.hpp"
#include "slicing/result/hash.hpp"

namespace lamella {

class FileSlicing {
public:
    FileSlicing(TriangleFile& file, const LayerSink& sink, const FileSliceOptions& options);

    /// Throws Refused, Stopped, std::bad_alloc.
    Result<FileSlice> run();
    /// The first pass alone. Throws as run().
    Result<FileOutline> outline();

private:
    Status first_pass();
    Status load_vertices();
    Status choose_grid_and_planes();
    Status build_planes();
    FileOutline known_outline() const;
    Array<std::uint64_t> layers_of_listed() const;
    void scan_file();
    void make_room(std::size_t chunk);
    void cut_rest();
    Status handle_collapse();

    bool cut_done_layers(PlaneIndex end);
    std::vector<LayerSpan> plan_rest() const;
    void spill();
    void cut(const LayerSpan& span);
    void collect_counts();
    std::uint64_t ended_below(PlaneIndex plane) const noexcept;
    [[noreturn]] void refuse_budget() const;
    void add(const SliceTotals& own);
    FileSlice finish();

    /// The caller's sink, with the hash taken on the way.
    struct Relay {
        const LayerSink& sink;
        std::optional<ResultHash> hash;
        void operator()(const LayerView& view) noexcept {
            if (hash) {
                hash->add_layer(view.layer, view.contours, view.points.data());
            }
            sink.take(sink.context, view);
        }
    };

    TriangleFile& file_;
    const FileSliceOptions& options_;
    SliceOptions slicing_;  ///< the caller's, with the file's unit in the transform
    Relay relay_;
    LayerSink sink_;
    Parallel parallel_;
    ProgressMeter progress_;
    std::uint64_t memory_limit_;  ///< SliceOptions::memory_limit_bytes
    MemoryModel model_;

    SharedFrame frame_{};
    std::vector<FileChunk> chunks_;
    PlaneSet planes_;
    PlaneCounts counts_;
    std::vector<std::unique_ptr<ChunkScan>> scans_;  ///< by worker
    TriangleStore store_;
    std::size_t limit_ = 0;    ///< of what is kept, before something must be done
    std::size_t touched_ = 0;  ///< the most that was kept
    std::optional<SpillFile> spill_;
    PlaneIndex done_ = 0;  ///< layers below it are handed over
    std::uint64_t cut_triangles_ = 0;
    std::uint64_t degenerate_ = 0;
    Workspace workspace_;
    std::uint64_t most_cut_ = 0;  ///< triangles of a range, in `workspace_`
    double cut_ms_ = 0;
    FileSlice done_work_;
};

}  // namespace lamella
