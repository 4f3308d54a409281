#include "io/stream/file_slicing.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/words.hpp"
#include "slicing/grid/placed_reader.hpp"
#include "slicing/handover/hand_over.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/repair/gap_length.hpp"
#include "slicing/workspace.hpp"

namespace lamella {

namespace {

constexpr double measured = 0.3;  ///< shares of the progress
constexpr double scanned = 0.6;

LayerSink in_order(LayerSink sink, bool ascending) noexcept {
    sink.order = ascending ? SinkOrder::ascending : sink.order;
    return sink;
}

}  // namespace

FileSlicing::FileSlicing(TriangleFile& file, const LayerSink& sink, const FileSliceOptions& options)
    : file_(file),
      options_(options),
      slicing_(options.slice),
      relay_{sink, {}},
      sink_(in_order(LayerSink::to(relay_, sink.order), options.hash)),
      parallel_({.threads = options.slice.control.threads,
                 .executor = options.slice.control.executor,
                 .stop = options.slice.control.stop}),
      progress_(options.slice.control.progress),
      memory_limit_(options.slice.memory_limit_bytes != 0 ? options.slice.memory_limit_bytes : detail::usual_memory_limit()),
      model_(options.memory_bytes != 0 ? options.memory_bytes : detail::usual_memory_limit(), parallel_.threads(), file),
      planes_(nullptr),
      store_(options.slice.control.memory) {
    slicing_.transform = slicing_.transform * Transform::scale(options.mm_per_unit);
    slicing_.allow_empty = true;
    slicing_.control.progress = {};
}

Result<FileSlice> FileSlicing::run() {
    const auto start = Clock::now();
    if (Status status = first_pass(); !status) {
        return status.error();
    }
    if (options_.outline.take != nullptr) {
        options_.outline.take(options_.outline.context, known_outline());
    }
    limit_ = model_.well_kept();
    // Pages that are not touched take no memory; a host's own memory may know no such thing.
    store_.reserve(slicing_.control.memory != nullptr ? limit_ : std::max(limit_, model_.most_kept()));
    scan_file();
    if (Status status = handle_collapse(); !status) {
        return status.error();
    }
    done_work_.totals.summary.ms.bucket += milliseconds_since(start) - cut_ms_;
    cut_rest();
    if (Status same = file_.unchanged(); !same) {
        return same.error();
    }
    progress_.finish();
    return finish();
}

Result<FileOutline> FileSlicing::outline() {
    if (Status status = first_pass(); !status) {
        return status.error();
    }
    return known_outline();
}

/// What is known of the result before its first layer is cut.
FileOutline FileSlicing::known_outline() const {
    FileOutline outline{SliceResult(slicing_.control.memory), planes_.size()};
    SliceResult& facts = outline.facts;
    facts.layer_of = layers_of_listed();
    facts.first_layer = planes_.first_kept();
    facts.all_layers = planes_.planned();
    facts.region = slicing_.region;
    facts.close_gaps_mm = gap_length_mm(slicing_.close_gaps_mm, frame_.bounds);
    facts.gap_sense = slicing_.gap_sense;
    facts.unit_mm = frame_.unit.mm;
    facts.frame = slicing_.transform;
    facts.plan = slicing_.plan;
    std::copy_n(frame_.bounds.min_mm, 3, facts.summary.min_mm);
    std::copy_n(frame_.bounds.max_mm, 3, facts.summary.max_mm);
    return outline;
}

/// SliceResult::layer_of.
Array<std::uint64_t> FileSlicing::layers_of_listed() const {
    const auto& listed = planes_.plane_of_listed();
    Array<std::uint64_t> layers(slicing_.control.memory);
    layers.resize_discarding(listed.size());
    std::copy(listed.begin(), listed.end(), layers.begin());
    return layers;
}

Status FileSlicing::first_pass() {
    const Status loaded = load_vertices();
    return loaded ? choose_grid_and_planes() : loaded;
}

Status FileSlicing::load_vertices() {
    if (model_.holds_resident()) {
        file_.load(slicing_.control.memory, parallel_);
        return {};
    }
    return file_.named(
        {ErrorCode::out_of_memory, "a budget of " + std::to_string(model_.budget()) + " bytes is too small: its " +
                                       counted(file_.facts().vertex_count, "vertex", "vertices") +
                                       " stay in memory, which takes at least " + std::to_string(model_.least_budget(1))});
}

Status FileSlicing::choose_grid_and_planes() {
    if (Status status = check_rules(slicing_.region); !status) {
        return status;
    }
    if (Status status = check_transform(slicing_.transform); !status) {
        return status;
    }
    Result<FileBox> box =
        measure_file(file_, slicing_.transform, slicing_.unit_mm, model_.chunk_triangles(), parallel_, progress_);
    if (!box) {
        return box.error();
    }
    chunks_ = std::move(box->chunks);
    frame_.bounds = box->bounds;
    const bool as_mesh = slicing_.transform.is_identity() || slicing_.transform.arithmetic == Arithmetic::as_mesh;
    frame_.number = as_mesh ? file_.facts().coordinate_type : CoordinateType::f64;
    const Result<ChosenUnit> unit = choose_unit_for(frame_.bounds, slicing_.unit_mm, slicing_.unit_fit, slicing_.region);
    if (!unit) {
        return unit.error().code == ErrorCode::bad_coordinate ? file_.named(unit.error()) : unit.error();
    }
    frame_.unit = *unit;
    return build_planes();
}

Status FileSlicing::build_planes() {
    if (Status status = planes_.build(slicing_.plan, frame_.bounds, frame_.unit.mm, frame_.number, memory_limit_); !status) {
        return status;
    }
    if (Status status = planes_.keep(slicing_.layers); !status) {
        return status;
    }
    counts_ = PlaneCounts(planes_.size());
    model_.set_planes(planes_.planned());
    if (options_.hash) {
        relay_.hash.emplace(planes_.size());
    }
    return {};
}

// --- The second pass

void FileSlicing::scan_file() {
    const std::size_t chunk_triangles = model_.chunk_triangles();
    const auto threads = static_cast<std::size_t>(parallel_.threads());
    scans_.resize(threads);
    for (std::size_t chunk = 0; chunk < chunks_.size();) {
        const std::size_t room = (limit_ - std::min(limit_, store_.size())) / chunk_triangles;
        if (room < std::min(threads, chunks_.size() - chunk)) {
            make_room(chunk);
            continue;
        }
        const std::size_t end = std::min(chunks_.size(), chunk + std::min(room, 64 * threads));
        parallel_.run(end - chunk, [&](std::size_t i, int worker) {
            const FileChunk& own = chunks_[chunk + i];
            const bool near = own.near || frame_.unit.doublings > 0;
            if (!near && lies_between_planes({own.low_mm, own.high_mm, false}, frame_.unit.mm, planes_)) {
                return;
            }
            auto& scan = scans_[static_cast<std::size_t>(worker)];
            if (scan == nullptr) {
                scan = std::make_unique<ChunkScan>(slicing_.transform, frame_.unit.mm, planes_, chunk_triangles,
                                                   file_.buffer_bytes());
            }
            const std::uint64_t first = (std::uint64_t{chunk} + i) * chunk_triangles;
            const std::size_t count = std::min<std::uint64_t>(chunk_triangles, file_.triangles() - first);
            store_.append(scan->scan(file_.read(first, count, scan->bytes()), near));
        });
        chunk = end;
        progress_.reach(measured + (scanned - measured) * static_cast<double>(chunk) / static_cast<double>(chunks_.size()));
    }
    collect_counts();
    for (const auto& scan : scans_) {
        degenerate_ += scan != nullptr ? scan->degenerate() : 0;
    }
    scans_.clear();
    chunks_ = {};
}

void FileSlicing::collect_counts() {
    for (const auto& scan : scans_) {
        if (scan != nullptr) {
            counts_.take(scan->counts());
        }
    }
}

/// Triangles whose last plane is below `plane`, of those seen so far.
std::uint64_t FileSlicing::ended_below(PlaneIndex plane) const noexcept {
    std::uint64_t ended = 0;
    for (PlaneIndex p = 0; p <= plane; ++p) {
        ended += counts_.ended(p);
    }
    return ended;
}

/// Memory is full before `chunk` is read.
void FileSlicing::make_room(std::size_t chunk) {
    collect_counts();
    touched_ = std::max(touched_, store_.size());
    if (!spill_) {
        const PlaneIndex end = planes_.first_above(to_even_grid(chunks_[chunk].low_from_here_mm, frame_.unit.mm));
        // What is kept began at or above `done_`, or reaches there, so all that ended below it is gone.
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

/// Whether these layers, or some of them, could be cut with what is kept.
bool FileSlicing::cut_done_layers(PlaneIndex end) {
    const PlaneIndex before = done_;
    store_.list(counts_, done_, planes_.size(), parallel_);
    while (done_ < end) {
        const std::optional<LayerSpan> span = model_.longest(counts_, done_, end, touched_);
        if (!span) {
            break;
        }
        cut(*span);
    }
    store_.unlist(done_);
    return done_ > before && store_.size() <= limit_ / 4 * 3;
}

void FileSlicing::spill() {
    if (!spill_) {
        const std::filesystem::path& folder = options_.temporary_folder;
        spill_.emplace(folder.empty() ? std::filesystem::temp_directory_path() : folder, counts_);
    }
    spill_->write(store_.triangles(), done_, parallel_);
    store_.clear();
}

// --- Cutting

/// All triangles collapse on the grid: an error, or as if there were none, whose box chooses no planes.
Status FileSlicing::handle_collapse() {
    if (degenerate_ != file_.triangles()) {
        return {};
    }
    if (!options_.slice.allow_empty) {
        return file_.named(all_collapsed(file_.triangles(), frame_.unit.mm));
    }
    frame_.bounds = {};
    return build_planes();
}

void FileSlicing::cut_rest() {
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
        progress_.reach(scanned + (1 - scanned) * static_cast<double>(span.end - begin) / static_cast<double>(end - begin));
    }
}

/// Empty if what is kept leaves too little to cut some layer, and could be spilled. The memory of what is spilled is made
/// anew for the largest range.
std::vector<LayerSpan> FileSlicing::plan_rest() const {
    std::vector<LayerSpan> spans;
    for (PlaneIndex next = done_; next < planes_.size(); next = spans.back().end) {
        const std::optional<LayerSpan> span = model_.longest(counts_, next, planes_.size(), spill_ ? 0 : touched_);
        if (!span && !spill_) {
            return {};
        }
        if (!span) {
            refuse_budget();
        }
        spans.push_back(*span);
    }
    if (planes_.size() == 0) {
        spans.push_back({0, 0, parallel_.threads(), 0});  // for its checks, and the summary
    }
    return spans;
}

void FileSlicing::refuse_budget() const {
    const std::size_t layer = counts_.widest();
    const std::uint64_t triangles = counts_.reaching_into(layer) + counts_.starting(layer);
    Error error;
    error.code = ErrorCode::out_of_memory;
    error.message = "a budget of " + std::to_string(model_.budget()) + " bytes is too small: layer " +
                    std::to_string(planes_.first_kept() + layer) + " alone, which cuts " + counted(triangles, "triangle") +
                    (file_.resident_bytes() > 0 ? ", with the vertices of all needs " : ", needs ") +
                    std::to_string(model_.least_budget(triangles));
    throw Refused{file_.named(error)};
}

void FileSlicing::cut(const LayerSpan& span) {
    SliceOptions options = slicing_;
    options.control.threads = span.threads;
    options.layers = {};
    if (span.end > span.begin) {
        options.layers = {std::uint64_t{planes_.first_kept()} + span.begin, std::uint64_t{planes_.first_kept()} + span.end};
    }
    if (span.triangles > most_cut_) {  // arrays that grow would be held twice
        workspace_.reset();
        most_cut_ = span.triangles;
    }
    const auto start = Clock::now();
    const ListedTriangles listed = store_.listed(span.begin, span.end);
    MeshView count_only;
    count_only.triangle_count = span.triangles;
    const detail::SliceInput input{.mesh = count_only, .frame = &frame_, .first_index = span.begin, .listed = &listed};
    Result<SliceTotals> own = hand_over(sink_, input, options, workspace_);
    if (!own) {
        throw Refused{own.error()};
    }
    store_.drop_swept(span.begin, span.end);
    done_ = span.end;
    cut_ms_ += milliseconds_since(start);
    add(*own);
}

void FileSlicing::add(const SliceTotals& own) {
    SliceTotals& all = done_work_.totals;
    ++done_work_.ranges;
    all.layers += own.layers;
    all.contours += own.contours;
    all.points += own.points;
    all.closed_gaps += own.closed_gaps;
    SliceSummary& sum = all.summary;
    const SliceSummary& part = own.summary;
    sum.segments += part.segments;
    sum.holes += part.holes;
    sum.open_contours += part.open_contours;
    sum.flat_contours += part.flat_contours;
    sum.overruled_contours += part.overruled_contours;
    sum.near_contours += part.near_contours;
    sum.emptied_layers += part.emptied_layers;
    sum.cancelled_layers += part.cancelled_layers;
    sum.bands += part.bands;
    sum.ms.bucket += part.ms.bucket;
    sum.ms.sweep += part.ms.sweep;
    sum.ms.contours += part.ms.contours;
    sum.ms.nesting += part.ms.nesting;
    sum.ms.fill += part.ms.fill;
}

FileSlice FileSlicing::finish() {
    SliceTotals& all = done_work_.totals;
    all.unit_mm = frame_.unit.mm;
    all.close_gaps_mm = gap_length_mm(slicing_.close_gaps_mm, frame_.bounds);
    all.first_layer = planes_.first_kept();
    all.all_layers = planes_.planned();
    all.layer_of = layers_of_listed();
    SliceSummary& sum = all.summary;
    sum.triangles = file_.triangles();
    sum.degenerate = degenerate_;
    for (PlaneIndex plane = 0; plane < planes_.size(); ++plane) {
        sum.crossed += counts_.starting(plane);
    }
    sum.unit_doublings = frame_.unit.doublings;
    sum.threads = parallel_.threads();
    std::copy_n(frame_.bounds.min_mm, 3, sum.min_mm);
    std::copy_n(frame_.bounds.max_mm, 3, sum.max_mm);
    done_work_.mesh = std::move(file_.facts());
    done_work_.spilled_bytes = spill_ ? spill_->bytes() : 0;
    done_work_.memory_bytes = model_.budget();
    if (relay_.hash) {
        done_work_.hash = relay_.hash->value();
    }
    return std::move(done_work_);
}

}  // namespace lamella
