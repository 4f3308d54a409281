#include "outputs/write_picture_output.hpp"

#include <algorithm>
#include <cmath>

#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

/// Of a direction in LPS: whether it is nearest to R, A or S, and not to L, P or I.
struct Nearest {
    std::size_t axis;
    bool negative;
};

Nearest nearest_axis(const std::array<double, 3>& direction) {
    const auto* const most =
        std::max_element(direction.begin(), direction.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
    return {static_cast<std::size_t>(most - direction.begin()), *most < 0};
}

/// Left, posterior and superior run to the right; right, anterior and superior run up.
void orient(PictureOptions& options, const ImageGeometry& image) {
    const Nearest x = nearest_axis(image.axes[0]);
    const Nearest y = nearest_axis(image.axes[1]);
    options.x_leftward = x.negative;
    options.y_downward = y.axis == 2 ? y.negative : !y.negative;
}

}  // namespace

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
    if (job.image) {
        orient(options, *job.image);
    }
    const std::optional<std::uint64_t> layer = job.arguments.picture_layer;
    done_or_thrown(layer ? write_layer_picture(parts, *layer, output.path, options)
                         : write_contact_sheet(parts, output.path, options));
}

}  // namespace lamella::cli
