#include "engine/slicing.hpp"

#include <sstream>

using lamella::Context;
using lamella::Contour;
using lamella::Error;
using lamella::LayerView;
using lamella::Point;
using lamella::SliceInfo;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::Source;
using lamella::Status;
using lamella::Tuning;

SliceOptions at_heights(std::vector<double> heights_mm, double grid_mm) {
    return {.heights_mm = std::move(heights_mm), .frame = {.grid_mm = grid_mm}};
}

SliceOptions uniform(double layer_height_mm, double grid_mm) {
    return {.layer_height_mm = layer_height_mm, .frame = {.grid_mm = grid_mm}};
}

SliceOptions through_quarters(std::uint64_t range) {
    std::vector<double> heights;
    for (std::uint64_t quarter = 1; quarter <= 4 * range; ++quarter) {
        heights.push_back(0.25 * static_cast<double>(quarter));
    }
    return at_heights(heights, 0.125);
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

SliceResult sliced(const Source& mesh, const SliceOptions& options, const Context& context, const Tuning& tuning) {
    SliceResult result(context.memory);
    (void)sliced_to(result, mesh, options, context, tuning);
    require_ok(audits::structure_of(result));
    return result;
}

SliceResult sliced(const shapes::Soup& soup, const SliceOptions& options, const Context& context, const Tuning& tuning) {
    return sliced(view_of(soup), options, context, tuning);
}

SliceInfo sliced_to(const lamella::Destination& to, const Source& mesh, const SliceOptions& options, const Context& context,
                    const Tuning& tuning) {
    lamella::Slicer slicer;
    return value_of(slice_tuned(slicer, to, mesh, options, tuning, context));
}

Error failure_of(const Source& mesh, const SliceOptions& options, const Context& context) {
    return error_of(slice(mesh, options, context));
}

std::vector<std::string> contours_at(const SliceResult& result, std::size_t layer) {
    const LayerView at = result[layer];
    std::vector<std::string> lines;
    for (const Contour& contour : at.contours) {
        std::ostringstream line;
        line << word_of(contour.role) << ' ' << "-0+"[contour.orientation + 1] << " x" << contour.segments << " in ";
        if (contour.parent < 0) {
            line << '-';
        } else {
            line << contour.parent - static_cast<std::int64_t>(at.first_contour);
        }
        line << ((contour.flags & lamella::orientation_overruled) != 0 ? " overruled" : "")
             << ((contour.flags & lamella::orientation_mixed) != 0 ? " mixed" : "") << ':';
        for (const Point p : at.points_of(contour)) {
            line << ' ' << p.x << ',' << p.y;
        }
        lines.push_back(line.str());
    }
    return lines;
}
