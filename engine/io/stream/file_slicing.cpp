// A slice of a file within a budget of memory, as the list of its stages.
#include "lamella/io/mesh_stream.hpp"

#include <mutex>

#include "base/clock.hpp"
#include "base/words.hpp"
#include "io/stream/chunk_scan.hpp"
#include "io/stream/memory_model.hpp"
#include "options/asked.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

/// The type and unit of its coordinates, which are not in memory.
MeshView numbers_of(const MeshFile& facts) noexcept {
    return {.vertex_type = facts.vertex_type, .mm_per_unit = facts.mm_per_unit};
}

constexpr double measured = 0.3;  ///< shares of the progress
constexpr double scanned = 0.6;

/// Adds what a range of layers took, and what is known of them once they are cut.
void add(const SliceInfo& part, SliceInfo& sum) noexcept {
    sum.bands += part.bands;
    for (const auto stage :
         {&StageTimes::bucket, &StageTimes::sweep, &StageTimes::contours, &StageTimes::nesting, &StageTimes::fill}) {
        sum.ms.*stage += part.ms.*stage;
    }
#define END_COUNTER(name) sum.name += part.name;
#include "options/counters.inc"
}

class FileSlicing {
public:
    /// `info` gets what is known of the slice.
    FileSlicing(const TriangleFile& file, const StreamOptions& stream, const SliceCall& call, SliceInfo& info)
        : file_(file),
          stream_(stream),
          call_(call),
          info_(info),
          options_(call.options),
          placing_(placing_of(numbers_of(file.facts()), call.options.frame)),
          parallel_(call.context),
          model_(stream.memory_bytes != 0 ? stream.memory_bytes : call.kept.usual_limit, parallel_.threads(), file),
          planes_(nullptr),
          store_(call.context.memory) {
        options_.allow_empty = true;
    }

    /// All layers to `target`. Throws Refused, Stopped, std::bad_alloc.
    MeshStream::Spent run(LayerTarget& target) {
        const auto start = Clock::now();
        target_ = &target;
        first_pass();
        limit_ = model_.well_kept();
        // Pages that are not touched take no memory; a host's own memory may know no such thing.
        store_.reserve(call_.context.memory != nullptr ? limit_ : std::max(limit_, model_.most_kept()));
        scan_file();
        handle_collapse();
        info_.ms.bucket += milliseconds_since(start) - cut_ms_;
        cut_rest();
        end_info();
        parallel_.finish();
        return {.ranges = ranges_, .spilled_bytes = spill_ ? spill_->bytes() : 0, .memory_bytes = model_.budget()};
    }

    /// All that is known before anything is cut.
    void outline() {
        first_pass();
        scan_chunks(0, chunks_.size(), false);
        end_scan();
        handle_collapse();
        end_info();
    }

private:
    /// Loads the vertices, and chooses grid and planes.
    void first_pass() {
        if (!model_.holds_resident()) {
            file_.refuse({ErrorCode::out_of_memory,
                          "a budget of " + std::to_string(model_.budget()) + " bytes is too small: its " +
                              counted(file_.facts().vertex_count, "vertex", "vertices") +
                              " stay in memory, which takes at least " + std::to_string(model_.least_budget(1))});
        }
        resident_ = file_.load(parallel_);
        const double asked_mm = call_.options.frame.grid_mm;
        FileBox box = measure_file(file_, resident_.span(), placing_, asked_mm, model_.chunk_triangles(), parallel_);
        chunks_ = std::move(box.chunks);
        try {
            frame_ = choose_frame(box.bounds, placed_number(numbers_of(file_.facts()), placing_), call_.options.frame,
                                  call_.options.region);
        } catch (const Refused& refused) {
            if (refused.error.code == ErrorCode::bad_coordinate) {
                file_.refuse(refused.error);
            }
            throw;
        }
        choose_planes();
    }

    /// And says all that is known before the first layer is cut.
    void choose_planes() {
        build_planes(call_, frame_, planes_);
        counts_ = PlaneCounts(planes_.size());
        model_.set_planes(planes_.planned(), !call_.options.slabs.empty());
        const StageTimes spent = info_.ms;
        begin_info(call_.options, frame_.bounds, frame_.unit, info_);
        describe_plan(planes_, call_.tuning.random_heights.has_value(), info_);
        info_.ms = spent;
    }

    /// All that is known of the triangles.
    void end_info() {
        file_.must_be_unchanged();
        info_.triangles = file_.triangles();
        info_.degenerate = degenerate_;
        info_.crossed = counts_.all();
        info_.segments = counts_.segments();
        info_.layers = planes_.size();
        info_.threads = parallel_.threads();
    }

    void scan_file() {
        const std::size_t chunk_triangles = model_.chunk_triangles();
        const auto threads = static_cast<std::size_t>(parallel_.threads());
        for (std::size_t chunk = 0; chunk < chunks_.size();) {
            const std::size_t room = (limit_ - std::min(limit_, store_.size())) / chunk_triangles;
            if (room < std::min(threads, chunks_.size() - chunk)) {
                make_room(chunk);
                continue;
            }
            const std::size_t end = std::min(chunks_.size(), chunk + std::min(room, 64 * threads));
            scan_chunks(chunk, end, true);
            chunk = end;
            parallel_.reach(measured +
                            (scanned - measured) * static_cast<double>(chunk) / static_cast<double>(chunks_.size()));
        }
        end_scan();
    }

    /// Counts what planes cut, and keeps it for them where asked to.
    void scan_chunks(std::size_t begin, std::size_t end, bool keep) {
        const std::size_t chunk_triangles = model_.chunk_triangles();
        scans_.resize(static_cast<std::size_t>(parallel_.threads()));
        parallel_.run(end - begin, [&](std::size_t i, int worker) {
            const FileChunk& own = chunks_[begin + i];
            const bool near = own.near || frame_.unit.doublings > 0;
            if (!near && lies_between_planes({own.low_mm, own.high_mm, false}, frame_.unit.mm, planes_)) {
                return;
            }
            auto& scan = scans_[static_cast<std::size_t>(worker)];
            if (scan == nullptr) {
                scan = std::make_unique<ChunkScan>(file_, resident_.span(), chunk_triangles, placing_, frame_.unit.mm,
                                                   planes_, call_.kept.instructions);
            }
            const std::span<const CrossedTriangle> found = scan->scan(begin + i, near);
            if (keep) {
                store_.append(found);
            }
        });
    }

    void end_scan() {
        collect_counts();
        for (const auto& scan : scans_) {
            degenerate_ += scan != nullptr ? scan->degenerate() : 0;
        }
        scans_.clear();
        chunks_ = {};
    }

    void collect_counts() {
        for (const auto& scan : scans_) {
            if (scan != nullptr) {
                counts_.take(scan->counts());
            }
        }
    }

    /// Memory is full before `chunk` is read.
    void make_room(std::size_t chunk) {
        collect_counts();
        touched_ = std::max(touched_, store_.size());
        if (!spill_) {
            const PlaneIndex end = planes_.first_above(to_even_grid(chunks_[chunk].low_from_here_mm, frame_.unit.mm));
            // Triangles that are kept began at or above `done_`, or reach there, so all that ended below it is gone.
            if (end > done_ && ended_below(end) - ended_below(done_) >= store_.size() / 4 && cut_done_layers(end)) {
                return;
            }
            if (limit_ < store_.capacity()) {
                limit_ = store_.capacity();
                return;
            }
        }
        spill();
    }

    /// All triangles collapse on the grid: an error, or as if there were none, whose box chooses no planes.
    void handle_collapse() {
        if (degenerate_ != file_.triangles()) {
            return;
        }
        if (!call_.options.allow_empty) {
            file_.refuse(all_collapsed(file_.triangles(), frame_.unit.mm));
        }
        frame_.bounds = {};
        choose_planes();
    }

    void cut_rest() {
        const PlaneIndex begin = done_;
        const PlaneIndex end = planes_.size();
        if (begin == end && begin > 0) {
            return;
        }
        touched_ = std::max(touched_, store_.size());
        if (spill_) {
            spill();
        }
        std::vector<LayerSpan> spans = plan_rest();
        if (spans.empty()) {
            spill();
            spans = plan_rest();
        }
        if (spill_) {
            const auto shorter = [](const LayerSpan& a, const LayerSpan& b) { return a.triangles < b.triangles; };
            store_.reserve(std::max_element(spans.begin(), spans.end(), shorter)->triangles);
        } else {
            store_.list(counts_, begin, end, parallel_);
        }
        for (const LayerSpan& span : spans) {
            if (spill_) {
                spill_->load(span.begin, span.end, begin, model_.chunk_triangles(), parallel_, store_);
                store_.list(counts_, span.begin, span.end, parallel_);
            }
            cut(span);
            if (spill_) {
                store_.unlist(span.end);
            }
            parallel_.reach(scanned +
                            (1 - scanned) * static_cast<double>(span.end - begin) / static_cast<double>(end - begin));
        }
    }

    /// True if these layers, or some of them, could be cut with what is kept.
    bool cut_done_layers(PlaneIndex end) {
        const PlaneIndex before = done_;
        store_.list(counts_, done_, planes_.size(), parallel_);
        for (std::optional<LayerSpan> span; done_ < end && (span = model_.longest(counts_, done_, end, touched_));) {
            cut(*span);
        }
        store_.unlist(done_);
        return done_ > before && store_.size() <= limit_ / 4 * 3;
    }

    /// Empty if what is kept leaves too little to cut some layer, and could be spilled. The memory of what is spilled is
    /// made anew for the largest range.
    std::vector<LayerSpan> plan_rest() const {
        std::vector<LayerSpan> spans;
        for (PlaneIndex next = done_; next < planes_.size(); next = spans.back().end) {
            const std::optional<LayerSpan> span = model_.longest(counts_, next, planes_.size(), spill_ ? 0 : touched_);
            if (!span && !spill_) {
                return {};
            }
            spans.push_back(span ? *span : refuse_budget());
        }
        if (planes_.size() == 0) {
            spans.push_back({0, 0, parallel_.threads(), 0});  // for its checks, and the summary
        }
        return spans;
    }

    void spill() {
        if (!spill_) {
            const std::filesystem::path& folder = stream_.temporary_folder;
            spill_.emplace(folder.empty() ? std::filesystem::temp_directory_path() : folder, counts_);
        }
        spill_->write(store_.triangles(), done_, parallel_);
        store_.clear();
    }

    void cut(const LayerSpan& span) {
        if (ranges_++ == 0) {
            target_->announce(info_);
        }
        const std::uint64_t first = planes_.first_kept();
        const bool some = span.end > span.begin;
        set_layers(options_, some ? first + span.begin : 0, some ? first + span.end : all_layers);
        Context context = parallel_.within(call_.context);
        context.stop = call_.context.stop;  // asked after each layer, too, whatever the time
        context.threads = span.threads;
        if (span.triangles > most_cut_) {  // arrays that grow would be held twice
            scratch_.reset();
            most_cut_ = span.triangles;
        }
        const auto start = Clock::now();
        const SliceCall call{options_, call_.tuning, context, detail::SlicerImpl::of(scratch_, context, call_.tuning)};
        ListedSource source(store_.listed(span.begin, span.end), span.triangles, frame_, call.kept.source_tools());
        SliceInfo own;
        slice_layers(source, target_, call, own, span.begin);
        add(own, info_);
        store_.drop_swept(span.begin, span.end);
        done_ = span.end;
        cut_ms_ += milliseconds_since(start);
    }

    /// Triangles whose last plane is below `plane`, of those seen so far.
    std::uint64_t ended_below(PlaneIndex plane) const noexcept {
        std::uint64_t ended = 0;
        for (PlaneIndex p = 0; p <= plane; ++p) {
            ended += counts_.ended(p);
        }
        return ended;
    }

    [[noreturn]] LayerSpan refuse_budget() const {
        const std::size_t layer = counts_.widest();
        const std::uint64_t triangles = counts_.reaching_into(layer) + counts_.starting(layer);
        file_.refuse(
            {ErrorCode::out_of_memory, "a budget of " + std::to_string(model_.budget()) + " bytes is too small: layer " +
                                           std::to_string(planes_.first_kept() + layer) + " alone, which cuts " +
                                           counted(triangles, "triangle") +
                                           (file_.resident_bytes() > 0 ? ", with the vertices of all needs " : ", needs ") +
                                           std::to_string(model_.least_budget(triangles))});
    }

    const TriangleFile& file_;
    const StreamOptions& stream_;
    const SliceCall& call_;
    SliceInfo& info_;
    LayerTarget* target_ = nullptr;
    SliceOptions options_;  ///< of a range
    Placing placing_;
    Parallel parallel_;
    MemoryModel model_;

    Array<std::byte> resident_;
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
    std::uint64_t degenerate_ = 0;
    Slicer scratch_;              ///< within the budget, unlike the caller's
    std::uint64_t most_cut_ = 0;  ///< triangles of a range, in `scratch_`
    double cut_ms_ = 0;
    std::uint64_t ranges_ = 0;
};

}  // namespace

struct MeshStream::Impl final : detail::SourceImpl {
    Impl(std::unique_ptr<TriangleFile> opened, const StreamOptions& options) : file(std::move(opened)), stream(options) {
        stream.read.name = {};  // the file has its own, and the caller's text may go
    }

    void slice(LayerTarget* target, const SliceCall& call, SliceInfo& info) const override {
        FileSlicing slicing(*file, stream, call, info);
        if (target == nullptr) {
            slicing.outline();
            return;
        }
        const Spent own = slicing.run(*target);
        const std::lock_guard lock(mutex);
        spent = own;
    }

    const std::unique_ptr<TriangleFile> file;
    StreamOptions stream;
    mutable std::mutex mutex;
    mutable Spent spent;  ///< with `mutex` held
};

MeshStream::MeshStream(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
MeshStream::MeshStream(MeshStream&&) noexcept = default;
MeshStream& MeshStream::operator=(MeshStream&&) noexcept = default;
MeshStream::~MeshStream() = default;

const MeshFile& MeshStream::about() const noexcept {
    return impl_->file->facts();
}

Source MeshStream::view() const noexcept {
    return static_cast<const detail::SourceImpl&>(*impl_);
}

MeshStream::Spent MeshStream::spent() const noexcept {
    const std::lock_guard lock(impl_->mutex);
    return impl_->spent;
}

Result<MeshStream> open_mesh(const std::filesystem::path& path, const StreamOptions& options) noexcept {
    return guarded([&]() -> Result<MeshStream> {
        return MeshStream(std::make_unique<MeshStream::Impl>(TriangleFile::open(path, options.read), options));
    });
}

}  // namespace lamella
