#include "slice/range_slicing.hpp"

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "files/standard_streams.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

/// Keeps what the summary tells of, and hands layers on.
class KeptLayers {
public:
    KeptLayers(StreamedOutputs& outputs, const StopCheck& stop) : outputs_(outputs), stop_(stop) {}

    OutlineSink outline() noexcept {
        return {
            [](void* context, const FileOutline& outline) noexcept { static_cast<KeptLayers*>(context)->begin(outline); },
            this};
    }
    void operator()(const LayerView& view) noexcept {
        try {
            layers_.push_back(view.layer);
            const Result<OpenLayers> open = find_open_layer(view, facts_.gap_sense, stop_);
            failed_ = failed_ || (!open && open.error().code == ErrorCode::out_of_memory);
            open_.add(open ? *open : OpenLayers{});
            gaps_.insert(gaps_.end(), view.closed_gaps.begin(), view.closed_gaps.end());
        } catch (...) {
            failed_ = true;
        }
        outputs_.add(view);
    }
    /// Also where more layers are for nothing.
    StopCheck stop() noexcept {
        return {[](void* context) noexcept {
                    const KeptLayers& own = *static_cast<KeptLayers*>(context);
                    return own.failed_ || own.outputs_.failed() || own.stop_.stop_requested();
                },
                this};
    }
    bool failed() const noexcept { return failed_; }
    const OpenLayers& open() const noexcept { return open_; }

    /// Without contours.
    SliceResult result(const SliceTotals& totals) && {
        copy_to(facts_.layers, layers_);
        copy_to(facts_.closed_gaps, gaps_);
        facts_.summary = totals.summary;
        return std::move(facts_);
    }

private:
    void begin(const FileOutline& outline) noexcept {
        const SliceResult& facts = outline.facts;
        facts_.first_layer = facts.first_layer;
        facts_.all_layers = facts.all_layers;
        facts_.region = facts.region;
        facts_.close_gaps_mm = facts.close_gaps_mm;
        facts_.gap_sense = facts.gap_sense;
        facts_.unit_mm = facts.unit_mm;
        facts_.frame = facts.frame;
        try {
            facts_.plan = facts.plan;
        } catch (...) {
            failed_ = true;
        }
        outputs_.begin(outline);
    }

    template <class T>
    static void copy_to(Array<T>& array, const std::vector<T>& from) {
        array.resize_discarding(from.size());
        std::copy(from.begin(), from.end(), array.begin());
    }

    StreamedOutputs& outputs_;
    const StopCheck& stop_;
    SliceResult facts_;
    std::vector<Layer> layers_;
    std::vector<ClosedGap> gaps_;
    OpenLayers open_;
    std::atomic<bool> failed_ = false;
};

/// $TMPDIR, else beside the output: the system's own folder is often held in memory.
std::filesystem::path temporary_folder(const SliceArguments& arguments) {
    const char* const asked = std::getenv("TMPDIR");
    if ((asked != nullptr && *asked != 0) || arguments.outputs.outputs.empty() || arguments.output_to_stdout()) {
        std::error_code none;
        const std::filesystem::path folder = std::filesystem::temp_directory_path(none);
        return none ? std::filesystem::path(".") : folder;
    }
    const std::filesystem::path folder = std::filesystem::path(arguments.outputs.outputs.front()).parent_path();
    return folder.empty() ? "." : folder;
}

FileSliceOptions file_options(const SliceArguments& arguments) {
    FileSliceOptions options;
    options.mm_per_unit = parse_unit(arguments.unit.value_or("mm"), "--unit");
    options.memory_bytes = parse_bytes(arguments.memory, "--memory");
    options.temporary_folder = temporary_folder(arguments);
    options.hash = arguments.hash;
    return options;
}

std::string words_of(const FileSlice& file) {
    std::string text =
        "ranges    " + counted(file.ranges, "range") + " of layers within " + file_size_text(file.memory_bytes);
    if (file.spilled_bytes > 0) {
        text += ", " + file_size_text(file.spilled_bytes) + " by way of a temporary file";
    }
    return text + "\n";
}

Result<SliceResult> stream_layers(const std::filesystem::path& path, const FileSliceOptions& options,
                                  StreamedOutputs& outputs, ToolRun& run) {
    KeptLayers kept(outputs, options.slice.control.stop);
    FileSliceOptions watched = options;
    watched.outline = kept.outline();
    watched.slice.control.stop = kept.stop();
    const Result<FileSlice> file = slice_file(path, LayerSink::to(kept, SinkOrder::ascending), watched);
    if (kept.failed()) {
        return Error{ErrorCode::out_of_memory, "out of memory"};
    }
    if (outputs.failed()) {
        outputs.finish();  // throws
    }
    if (!file) {
        return file.error();
    }
    run.contours = file->totals.contours;
    run.open = kept.open();
    run.hash = file->hash;
    run.ranges = words_of(*file);
    return std::move(kept).result(file->totals);
}

}  // namespace

void require_ranges_possible(const SliceArguments& arguments) {
    if (arguments.memory.empty()) {
        return;
    }
    (void)parse_bytes(arguments.memory, "--memory");
    if (!arguments.report.empty()) {
        throw Failure(bad_usage, "--memory: --report looks at the whole mesh, which is not held");
    }
    for (const std::string& mesh : arguments.meshes) {
        if (is_standard(mesh)) {
            throw Failure(bad_usage, "--memory: standard input cannot be read twice; write it to a file first");
        }
    }
}

MeshFile describe_mesh_of(const SliceArguments& arguments) {
    return done_or_thrown(describe_file(arguments.mesh, file_options(arguments)));
}

FileOutline outline_within_memory(const std::string& mesh, const SliceArguments& arguments, const SliceOptions& options) {
    FileSliceOptions in_file = file_options(arguments);
    in_file.slice = options;
    return done_or_thrown(outline_file(mesh, in_file));
}

Result<SliceResult> slice_in_ranges(const SliceArguments& arguments, const SliceOptions& options, StreamedOutputs* outputs,
                                    ToolRun& run) {
    FileSliceOptions in_file = file_options(arguments);
    in_file.slice = options;
    if (outputs != nullptr) {
        in_file.hash = in_file.hash || outputs->have_records();
        return stream_layers(arguments.mesh, in_file, *outputs, run);
    }
    Result<CollectedFileSlice> collected = slice_file(arguments.mesh, in_file);
    if (!collected) {
        return collected.error();
    }
    run.hash = collected->file.hash;
    run.ranges = words_of(collected->file);
    return std::move(collected->result);
}

}  // namespace lamella::cli
