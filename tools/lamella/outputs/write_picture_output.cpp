#include "outputs/write_picture_output.hpp"

#include <algorithm>

#include "terminal/failure.hpp"

namespace lamella::cli {

void require_picture_possible(const std::vector<PlannedOutput>& outputs, const OutputArguments& arguments) {
    const auto picture = std::find_if(outputs.begin(), outputs.end(),
                                      [](const PlannedOutput& output) { return output.format == OutputFormat::png; });
    if (arguments.picture_layer && picture == outputs.end()) {
        throw Failure(bad_usage, "--picture-layer: no output is a PNG");
    }
    if (picture != outputs.end() && !can_write_pictures()) {
        throw Failure(bad_usage, "cannot write '" + picture->path + "': this build of lamella is without PNG (libpng-dev)");
    }
}

void write_picture_output(const OutputJob& job, const PlannedOutput& output, const Control& control) {
    std::vector<PicturePart> parts;
    for (const SlicedPart& part : job.parts) {
        parts.push_back({&part.result, part.name});
    }
    PictureOptions options;
    options.control = control;
    options.image = job.image ? &*job.image : nullptr;
    const std::optional<std::uint64_t> layer = job.arguments.picture_layer;
    done_or_thrown(layer ? write_layer_picture(parts, *layer, output.path, options)
                         : write_contact_sheet(parts, output.path, options));
}

}  // namespace lamella::cli
