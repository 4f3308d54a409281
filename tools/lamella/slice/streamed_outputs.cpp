#include "slice/slice_stages.hpp"

#include <algorithm>
#include <utility>

#include "files/streams.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

/// std::visit() could throw.
template <class Stream, class Use>
auto of_its_kind(Stream& stream, Use use) noexcept {
    auto* const svg = std::get_if<SvgStream>(&stream);
    return svg != nullptr ? use(*svg) : use(*std::get_if<LayerTableStream>(&stream));
}

template <class T>
void copy_to(Array<T>& array, const std::vector<T>& from) {
    array.resize_discarding(from.size());
    std::copy(from.begin(), from.end(), array.begin());
}

void tell_ranges(const FileSlice& file, ToolRun& run) {
    run.hash = file.hash;
    run.ranges = "ranges    " + counted(file.ranges, "range") + " of layers within " + file_size_text(file.memory_bytes) +
                 (file.spilled_bytes > 0 ? ", " + file_size_text(file.spilled_bytes) + " by way of a temporary file" : "") +
                 "\n";
}

}  // namespace

bool StreamedOutputs::serve(const std::vector<PlannedOutput>& outputs) {
    return std::all_of(outputs.begin(), outputs.end(), [](const PlannedOutput& output) {
        return output.format == OutputFormat::svg || output.format == OutputFormat::csv ||
               output.format == OutputFormat::json_lines;
    });
}

StreamedOutputs::StreamedOutputs(std::vector<PlannedOutput> outputs, std::string mesh_name, const ImageGeometry* image)
    : outputs_(std::move(outputs)), mesh_name_(std::move(mesh_name)), image_(image) {}

Result<SliceResult> StreamedOutputs::slice(const std::string& mesh, FileSliceOptions options, ToolRun& run) {
    stop_ = options.slice.control.stop;
    options.hash = options.hash || std::any_of(outputs_.begin(), outputs_.end(),
                                               [](const PlannedOutput& output) { return output.has_record(); });
    options.outline = {
        [](void* own, const FileOutline& outline) noexcept { static_cast<StreamedOutputs*>(own)->begin(outline); }, this};
    options.slice.control.stop = {[](void* context) noexcept {
                                      const auto& own = *static_cast<StreamedOutputs*>(context);
                                      return own.out_of_memory_ || own.failed() || own.stop_.stop_requested();
                                  },
                                  this};
    const Result<FileSlice> file = slice_file(mesh, LayerSink::to(*this, SinkOrder::ascending), options);
    if (out_of_memory_) {
        return Error{ErrorCode::out_of_memory, "out of memory"};
    }
    if (failed()) {
        finish();  // throws
    }
    if (!file) {
        return file.error();
    }
    copy_to(facts_.layers, layers_);
    copy_to(facts_.closed_gaps, gaps_);
    facts_.summary = file->totals.summary;
    run.contours = file->totals.contours;
    run.open = open_;
    tell_ranges(*file, run);
    return std::move(facts_);
}

void StreamedOutputs::begin(const FileOutline& outline) noexcept {
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
        for (const PlannedOutput& output : outputs_) {
            Result<Stream> stream = open(output, outline);
            if (!stream) {
                begun_ = stream.error();
                return;
            }
            streams_.push_back(std::move(stream).value());
        }
    } catch (...) {
        out_of_memory_ = true;
    }
}

Result<StreamedOutputs::Stream> StreamedOutputs::open(const PlannedOutput& output, const FileOutline& outline) const {
    const auto as_stream = [](auto begun) -> Result<Stream> {
        return begun ? Result<Stream>(Stream(std::move(begun).value())) : begun.error();
    };
    return output.format == OutputFormat::svg
               ? as_stream(SvgStream::begin(outline.facts, outline.layers, output_path(output.path)))
               : as_stream(LayerTableStream::begin(mesh_name_, output.path, image_));
}

void StreamedOutputs::operator()(const LayerView& view) noexcept {
    try {
        layers_.push_back(view.layer);
        const Result<OpenLayers> open = find_open_layer(view, facts_.gap_sense, stop_);
        out_of_memory_ = out_of_memory_ || (!open && open.error().code == ErrorCode::out_of_memory);
        open_.add(open ? *open : OpenLayers{});
        gaps_.insert(gaps_.end(), view.closed_gaps.begin(), view.closed_gaps.end());
    } catch (...) {
        out_of_memory_ = true;
    }
    for (Stream& stream : streams_) {
        of_its_kind(stream, [&](auto& own) { own.add(view); });
    }
}

bool StreamedOutputs::has_failed(const Stream& stream) noexcept {
    return of_its_kind(stream, [](const auto& own) { return own.failed(); });
}

bool StreamedOutputs::failed() const noexcept {
    return !begun_ || std::any_of(streams_.begin(), streams_.end(), has_failed);
}

void StreamedOutputs::finish() {
    Status status = begun_;
    // Streams that failed come first: they ended the slicing, and the others lack layers.
    std::stable_partition(streams_.begin(), streams_.end(), has_failed);
    for (Stream& stream : streams_) {
        if (status) {
            status = of_its_kind(stream, [](auto& own) { return own.finish(); });
        }
    }
    done_or_thrown(status);
}

Result<SliceResult> slice_in_ranges(const std::string& mesh, const FileSliceOptions& options, StreamedOutputs* outputs,
                                    ToolRun& run) {
    if (outputs != nullptr) {
        return outputs->slice(mesh, options, run);
    }
    Result<CollectedFileSlice> collected = slice_file(mesh, options);
    if (!collected) {
        return collected.error();
    }
    tell_ranges(collected->file, run);
    return std::move(collected->result);
}

}  // namespace lamella::cli
