#include "engine/slicing.hpp"

#include <sstream>

using lamella::Contour;
using lamella::Error;
using lamella::Layer;
using lamella::MeshView;
using lamella::Point;
using lamella::Result;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::Status;

SliceOptions at_heights(std::vector<double> heights_mm) {
    SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{std::move(heights_mm)};
    options.unit_mm = coarse_unit_mm;
    options.control.threads = 1;
    return options;
}

SliceOptions uniform(double layer_height_mm, double unit_mm) {
    SliceOptions options;
    options.plan.spacing = lamella::UniformLayers{layer_height_mm};
    options.unit_mm = unit_mm;
    return options;
}

lamella::SliceOptions through_quarters(std::uint64_t range) {
    std::vector<double> heights;
    for (std::uint64_t quarter = 1; quarter <= 4 * range; ++quarter) {
        heights.push_back(0.25 * static_cast<double>(quarter));
    }
    lamella::SliceOptions options = at_heights(heights);
    options.unit_mm = 0.125;
    return options;
}

shapes::Soup generated(lamella::models::Shape shape, std::uint64_t triangles, std::uint64_t seed) {
    const std::vector<float> soup =
        lamella::models::make_soup({.shape = shape, .triangles = triangles, .height_mm = 20, .seed = seed});
    return {soup.begin(), soup.end()};
}

void require_ok(const Status& status) {
    INFO((status ? std::string() : status.error().message));
    REQUIRE(status.ok());
}

namespace {

SliceResult valid(Result<SliceResult> made) {
    SliceResult result = value_of(std::move(made));
    require_ok(validate(result));
    return result;
}

}  // namespace

SliceResult sliced(const MeshView& mesh, const SliceOptions& options) {
    return valid(slice(mesh, options));
}

SliceResult sliced(const shapes::Soup& soup, const SliceOptions& options) {
    return sliced(view_of(soup), options);
}

SliceResult sliced(const std::vector<lamella::Part>& parts, const SliceOptions& options, lamella::PartRegions regions) {
    return valid(slice_parts(parts, options, regions));
}

Error failure_of(const MeshView& mesh, const SliceOptions& options) {
    return error_of(slice(mesh, options));
}

std::vector<std::string> contours_at(const SliceResult& result, std::size_t layer) {
    const Layer& at = result.layers[layer];
    const char* roles[] = {"outer", "hole", "flat", "open"};
    std::vector<std::string> lines;
    for (const Contour& contour : result.contours_of(at)) {
        std::ostringstream line;
        line << roles[static_cast<std::size_t>(contour.role)] << ' ' << "-0+"[contour.orientation + 1] << " x"
             << contour.segments << " in ";
        if (contour.parent < 0) {
            line << '-';
        } else {
            line << contour.parent - static_cast<std::int64_t>(at.first_contour);
        }
        line << ((contour.flags & lamella::orientation_overruled) != 0 ? " overruled" : "")
             << ((contour.flags & lamella::orientation_mixed) != 0 ? " mixed" : "") << ':';
        for (const Point p : result.points_of(contour)) {
            line << ' ' << p.x << ',' << p.y;
        }
        lines.push_back(line.str());
    }
    return lines;
}
