#include "lamella/medical/geometry.hpp"

#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

Transform ImageGeometry::slicing_frame(PatientFrame frame) const noexcept {
    const std::array<std::array<double, 3>, 3> rows = {axes[0], axes[1], cross(axes[0], axes[1])};
    const double mirror = frame == PatientFrame::ras ? -1 : 1;  // of the first two coordinates: RAS to LPS
    Transform to;
    for (std::size_t row = 0; row < 3; ++row) {
        to.m[4 * row] = mirror * rows[row][0];
        to.m[4 * row + 1] = mirror * rows[row][1];
        to.m[4 * row + 2] = rows[row][2];
        to.m[4 * row + 3] = -dot(rows[row], origin_mm);
    }
    return to;
}

std::array<std::array<double, 3>, 3> ImageGeometry::steps_mm() const noexcept {
    std::array<std::array<double, 3>, 3> steps{};
    for (std::size_t i = 0; i < 9; ++i) {
        steps[i / 3][i % 3] = axes[i / 3][i % 3] * spacing_mm[i / 3];
    }
    for (std::size_t i = 0; is_sheared() && i < 3; ++i) {
        steps[2][i] += axes[0][i] * shear_mm[0] + axes[1][i] * shear_mm[1];
    }
    return steps;
}

std::string ImageGeometry::uneven_words() const {
    std::vector<double> steps;
    for (std::size_t slice = 1; slice < uneven_slices_mm.size(); ++slice) {
        steps.push_back(uneven_slices_mm[slice] - uneven_slices_mm[slice - 1]);
    }
    if (steps.empty()) {
        return {};
    }
    const double usual = median(steps);
    const auto most = std::max_element(steps.begin(), steps.end(),
                                       [&](double a, double b) { return std::abs(a - usual) < std::abs(b - usual); });
    const auto slice = static_cast<std::size_t>(most - steps.begin());
    const auto name = [&](std::size_t k) {
        const std::uint64_t frame = series ? series->slices[k].frame : 0;
        return !series ? "slice " + std::to_string(k)
                       : (frame == 0 ? "" : "frame " + std::to_string(frame) + " of ") + series->slices[k].file;
    };
    return rounded_mm(*most) + " from " + name(slice) + " to " + name(slice + 1) + ", else " + rounded_mm(usual);
}

std::vector<double> ImageGeometry::slice_heights_mm(int subslices) const {
    const double hand = dot(axes[2], cross(axes[0], axes[1])) < 0 ? -1 : 1;
    const auto centre = [&](std::uint64_t slice) {
        return slice < uneven_slices_mm.size() ? uneven_slices_mm[slice] : static_cast<double>(slice) * spacing_mm[2];
    };
    std::vector<double> heights;
    for (std::uint64_t slice = 0; slice < size[2]; ++slice) {
        for (int part = 0; part < subslices; ++part) {
            heights.push_back(hand * (centre(slice) + ((part + 0.5) / subslices - 0.5) * spacing_mm[2]));
        }
    }
    return heights;
}

std::array<double, 3> ImageGeometry::to_lps(const std::array<double, 3>& sliced_mm) const noexcept {
    const Direction normal = cross(axes[0], axes[1]);
    std::array<double, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) {
        at[i] = origin_mm[i] + axes[0][i] * sliced_mm[0] + axes[1][i] * sliced_mm[1] + normal[i] * sliced_mm[2];
    }
    return at;
}

std::size_t ImageGeometry::slice_axis() const noexcept {
    return nearest_axis(cross(axes[0], axes[1])).axis;
}

double ImageGeometry::height_lps_mm(double height_mm) const noexcept {
    const Direction normal = cross(axes[0], axes[1]);
    const double along = dot(normal, origin_mm) + height_mm;
    return nearest_axis(normal).negative ? -along : along;
}

namespace {

constexpr double largest_voxel_mm = 1e6;  ///< coordinates end at 1e9
constexpr double rounding = 1e-3;         ///< of a voxel
constexpr double largest_cosine = 1e-4;   ///< of axes that count as perpendicular

constexpr std::array<const char*, 3> axis_names = {"i", "j", "k"};

}  // namespace

Result<ImageGeometry> geometry_around(const Box& box, const std::array<double, 3>& spacing_mm) noexcept {
    return guarded([&]() -> Result<ImageGeometry> {
        ImageGeometry image;
        image.spacing_mm = spacing_mm;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double spacing = spacing_mm[axis];
            if (!(spacing > 0 && spacing <= largest_voxel_mm)) {
                return Error{ErrorCode::invalid_argument, "a voxel's size must be a number of mm above 0, and at most 1e6"};
            }
            const double extent = box.max_mm[axis] - box.min_mm[axis];
            const double needed = std::ceil(extent / spacing - rounding);
            const double count = std::max(1.0, needed);
            if (!(needed >= 0 && needed <= static_cast<double>(largest_image_side))) {
                return Error{ErrorCode::invalid_argument, "voxels of that size are too many around the mesh"};
            }
            const double middle = box.min_mm[axis] + extent / 2;
            const double origin = middle - (count - 1) / 2 * spacing;
            const auto as_float = static_cast<double>(static_cast<float>(origin));  // where that is next to nothing
            image.origin_mm[axis] = std::abs(as_float - origin) <= rounding * spacing ? as_float : origin;
            image.size[axis] = static_cast<std::uint64_t>(count);
        }
        return image;
    });
}

void refuse_unreadable(const std::string& name, int error_number) {
    throw Refused{
        {.code = ErrorCode::unreadable_file, .message = "cannot read '" + name + "': " + system_message(error_number)}};
}

void refuse_image(const std::string& name, const std::string& what) {
    throw Refused{{.code = ErrorCode::malformed_mesh, .message = name + ": " + what}};
}

void refuse_output(const std::filesystem::path& path, const std::string& what) {
    throw Refused{{ErrorCode::invalid_argument, "'" + path_text(path) + "': " + what}};
}

void require_cut(const SliceResult* result, const std::string& name, std::uint64_t heights, std::size_t first,
                 std::size_t count) {
    const auto is_there = [&](std::uint64_t layer) { return layer - result->info.first_layer < result->layers.size(); };
    if (result == nullptr || result->info.layer_of.size() != heights ||
        !std::ranges::all_of(std::span(result->info.layer_of).subspan(first, count), is_there)) {
        throw Refused{{ErrorCode::invalid_argument, "'" + name + "' was not cut at the slices of the image"}};
    }
}

void warn_of_shear(ImageGeometry& image, const std::string& name) {
    if (image.is_sheared()) {
        image.warnings.push_back(name + ": the image is sheared, as by a tilted gantry: each slice lies " +
                                 rounded_mm(length({image.shear_mm[0], image.shear_mm[1], 0})) +
                                 " aside of the one before; masks keep to the slices' own voxels");
    }
}

ImageGeometry upright(const std::string& name, const std::array<std::uint64_t, 3>& size,
                      const std::array<Direction, 3>& steps, const Direction& origin) {
    ImageGeometry image;
    image.size = size;
    image.origin_mm = origin;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double step = length(steps[axis]);
        if (!std::isfinite(step) || step <= 0 || !std::isfinite(origin[axis])) {
            refuse_image(name, "the distance of voxels along " + std::string(axis_names[axis]) +
                                   ", or the origin, is no finite length");
        }
        if (size[axis] == 0 || size[axis] > largest_image_side) {
            refuse_image(name, std::to_string(size[axis]) + " voxels along " + axis_names[axis]);
        }
        image.spacing_mm[axis] = step;
        image.axes[axis] = scaled(steps[axis], 1 / step);
    }
    const auto cosine = [&](std::size_t a, std::size_t b) { return std::abs(dot(image.axes[a], image.axes[b])); };
    if (cosine(0, 1) > largest_cosine) {
        refuse_image(name, "sheared: the axes i and j are not perpendicular");
    }
    const bool sheared = std::max(cosine(0, 2), cosine(1, 2)) > largest_cosine;
    // Axes are made exactly perpendicular: the header rounds them.
    const Direction normal = cross(image.axes[0], image.axes[1]);
    const Direction upright_k = scaled(normal, (dot(normal, image.axes[2]) < 0 ? -1 : 1) / length(normal));
    image.axes[1] = scaled(cross(normal, image.axes[0]), 1 / length(normal));
    image.axes[2] = upright_k;
    if (sheared) {
        image.shear_mm = {dot(steps[2], image.axes[0]), dot(steps[2], image.axes[1])};
        image.spacing_mm[2] = dot(steps[2], upright_k);
        if (image.spacing_mm[2] < largest_cosine * length(steps[2])) {
            refuse_image(name, "sheared: the axis k lies in the slices");
        }
    }
    warn_of_shear(image, name);
    return image;
}

Result<ImageGeometry> read_image_geometry(const std::filesystem::path& path, const ImageOptions& options,
                                          const Context& context) noexcept {
    return guarded(context, [&]() -> Result<ImageGeometry> {
        std::error_code unknown;
        if (std::filesystem::is_directory(path, unknown)) {
            return read_dicom_folder(path, options.series_uid, context.stop);
        }
        if (!options.series_uid.empty()) {
            return Error{ErrorCode::invalid_argument, path_text(path) + ": no folder, whose DICOM series --series names"};
        }
        return read_image_file(path);
    });
}

}  // namespace lamella
