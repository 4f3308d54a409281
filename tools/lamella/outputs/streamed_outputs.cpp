#include "outputs/streamed_outputs.hpp"

#include <algorithm>
#include <utility>

#include "files/output_path.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

/// std::visit() could throw.
template <class Stream, class Use>
auto of_its_kind(Stream& stream, Use use) noexcept {
    auto* const svg = std::get_if<SvgStream>(&stream);
    return svg != nullptr ? use(*svg) : use(*std::get_if<LayerTableStream>(&stream));
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

bool StreamedOutputs::have_records() const {
    return std::any_of(outputs_.begin(), outputs_.end(), [](const PlannedOutput& output) { return output.has_record(); });
}

void StreamedOutputs::begin(const FileOutline& outline) noexcept {
    try {
        for (const PlannedOutput& output : outputs_) {
            Result<Stream> stream = open(output, outline);
            if (!stream) {
                begun_ = stream.error();
                return;
            }
            streams_.push_back(std::move(stream).value());
        }
    } catch (...) {
        begun_ = Error{ErrorCode::out_of_memory, "out of memory"};
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

void StreamedOutputs::add(const LayerView& view) noexcept {
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
    // Those that failed first: they ended the slicing, and the others lack layers.
    std::stable_partition(streams_.begin(), streams_.end(), has_failed);
    for (Stream& stream : streams_) {
        if (status) {
            status = of_its_kind(stream, [](auto& own) { return own.finish(); });
        }
    }
    done_or_thrown(status);
}

}  // namespace lamella::cli
