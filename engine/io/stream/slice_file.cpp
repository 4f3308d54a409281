#include "lamella/slice_file.hpp"

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "io/stream/file_slicing.hpp"

namespace lamella {

namespace {

Result<std::unique_ptr<TriangleFile>> open(const std::filesystem::path& path, const FileSliceOptions& options) {
    const Parallel one({.threads = 1});
    return TriangleFile::open(path, options.name, options.mm_per_unit, one);
}

/// What no file can be sliced with within a budget.
Status check_options(const FileSliceOptions& options) {
    if (options.slice.origins) {
        return Error{ErrorCode::invalid_argument, "origins are not to be had within a budget of memory"};
    }
    return {};
}

Result<FileSlice> run(const std::filesystem::path& path, const LayerSink& sink, const FileSliceOptions& options) {
    if (sink.take == nullptr) {
        return Error{ErrorCode::invalid_argument, "the sink has no function that takes layers"};
    }
    if (Status status = check_options(options); !status) {
        return status.error();
    }
    const Clock::time_point start = Clock::now();
    const Result<std::unique_ptr<TriangleFile>> opened = open(path, options);
    if (!opened) {
        return opened.error();
    }
    TriangleFile& file = **opened;
    file.facts().read_ms = milliseconds_since(start);
    return FileSlicing(file, sink, options).run();
}

/// `array` with room for `count` more, half as many again as it has at least.
template <class T>
T* room_for(Array<T>& array, std::size_t count) {
    const std::size_t size = array.size();
    if (size + count > array.capacity()) {
        Array<T> larger(array.memory());
        larger.resize_discarding(std::max(size + count, size + size / 2));
        std::copy(array.begin(), array.end(), larger.begin());
        array = std::move(larger);
    }
    array.set_size(size + count);
    return array.data() + size;
}

/// Puts layers that come in ascending order behind one another.
class Collector {
public:
    explicit Collector(SliceResult& result, const StopCheck& stop) : result_(result), stop_(stop) {}

    void operator()(const LayerView& view) noexcept {
        if (failed_) {
            return;
        }
        try {
            append(view);
        } catch (...) {  // out of memory: the call is asked to end
            failed_ = true;
        }
    }
    StopCheck stop() noexcept {
        return {[](void* context) noexcept {
                    const Collector& own = *static_cast<Collector*>(context);
                    return own.failed_ || own.stop_.stop_requested();
                },
                this};
    }
    bool failed() const noexcept { return failed_; }

private:
    void append(const LayerView& view) {
        const std::uint64_t first_contour = result_.contours.size();
        const std::uint64_t first_point = result_.points.size();
        Layer& layer = *room_for(result_.layers, 1);
        layer = view.layer;
        layer.first_contour = first_contour;
        std::transform(view.contours.begin(), view.contours.end(), room_for(result_.contours, view.contours.size()),
                       [&](Contour contour) {
                           contour.first_point += first_point;
                           contour.parent += contour.parent < 0 ? 0 : static_cast<std::int64_t>(first_contour);
                           return contour;
                       });
        std::copy(view.points.begin(), view.points.end(), room_for(result_.points, view.points.size()));
        std::copy(view.closed_gaps.begin(), view.closed_gaps.end(), room_for(result_.closed_gaps, view.closed_gaps.size()));
    }

    SliceResult& result_;
    const StopCheck& stop_;
    std::atomic<bool> failed_ = false;
};

Result<CollectedFileSlice> collect(const std::filesystem::path& path, const FileSliceOptions& options) {
    SliceResult result(options.slice.control.memory);
    Collector collector(result, options.slice.control.stop);
    FileSliceOptions watched = options;
    watched.slice.control.stop = collector.stop();
    Result<FileSlice> file = run(path, LayerSink::to(collector, SinkOrder::ascending), watched);
    if (collector.failed()) {
        return Error{ErrorCode::out_of_memory, "out of memory"};
    }
    if (!file) {
        return file.error();
    }
    SliceTotals& totals = file->totals;
    result.layer_of = std::move(totals.layer_of);
    result.first_layer = totals.first_layer;
    result.all_layers = totals.all_layers;
    result.region = options.slice.region;
    result.close_gaps_mm = totals.close_gaps_mm;
    result.gap_sense = options.slice.gap_sense;
    result.unit_mm = totals.unit_mm;
    result.frame = options.slice.transform * Transform::scale(options.mm_per_unit);
    result.plan = options.slice.plan;
    result.summary = totals.summary;
    return CollectedFileSlice{std::move(file).value(), std::move(result)};
}

}  // namespace

Result<MeshFile> describe_file(const std::filesystem::path& path, const FileSliceOptions& options) noexcept {
    return guarded(options.slice.control, [&]() -> Result<MeshFile> {
        const Result<std::unique_ptr<TriangleFile>> file = open(path, options);
        if (!file) {
            return file.error();
        }
        return std::move((*file)->facts());
    });
}

Result<FileOutline> outline_file(const std::filesystem::path& path, const FileSliceOptions& options) noexcept {
    return guarded(options.slice.control, [&]() -> Result<FileOutline> {
        if (Status status = check_options(options); !status) {
            return status.error();
        }
        const Result<std::unique_ptr<TriangleFile>> file = open(path, options);
        if (!file) {
            return file.error();
        }
        return FileSlicing(**file, LayerSink{}, options).outline();
    });
}

Result<FileSlice> slice_file(const std::filesystem::path& path, const LayerSink& sink,
                             const FileSliceOptions& options) noexcept {
    return guarded(options.slice.control, [&] { return run(path, sink, options); });
}

Result<CollectedFileSlice> slice_file(const std::filesystem::path& path, const FileSliceOptions& options) noexcept {
    try {
        return guarded(options.slice.control, [&] { return collect(path, options); });
    } catch (...) {
        return Error{ErrorCode::out_of_memory, "out of memory"};
    }
}

}  // namespace lamella
