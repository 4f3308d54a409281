// Layered SVG. Layers are painted from the lowest up, each opaque and lighter than the one below, so that a viewer which
// shows all of them at once shows the part from above as a relief; one that shows a layer at a time shows dark on white.
//
// Holes are polygons of their own in Slic3r's convention and cannot be cut out of another one, so they are painted white
// over the contour around them. The canonical order (outer, then its holes, then what starts inside these) makes that right
// wherever contours do not cross.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/words.hpp"
#include "io/layers/layer_writer.hpp"
#include "io/text/mm_text.hpp"
#include "options/asked.hpp"

namespace lamella {

namespace svg {

using Shade = std::array<int, 3>;
constexpr Shade lowest_colour{16, 32, 51};
constexpr Shade highest_colour{112, 160, 198};
constexpr std::string_view warning_colour = "#d9302c";

constexpr double margin = 0.02;           ///< around the mesh, of its larger extent
constexpr double warning_stroke = 0.002;  ///< of the same

class SvgWriter final : public LayerWriter {
public:
    SvgWriter(const SliceInfo& info, const StopCheck& stop, OutputFile& out)
        : layers_(info.layers),
          parts_(info.part_count),
          stitching_(describe_stitching(info.options)),
          out_(out),
          format_(info.grid_mm),
          extent_(
              std::max({info.box.max_mm[0] - info.box.min_mm[0], info.box.max_mm[1] - info.box.min_mm[1], info.grid_mm})) {
        pace_.follow(stop);
    }

    void head(const SliceInfo& info, const WeldedMesh* welded) {
        const auto& low = info.box.min_mm;
        const auto& high = info.box.max_mm;
        const double border = margin * extent_;
        const std::string width = mm(high[0] - low[0] + 2 * border);
        const std::string height = mm(high[1] - low[1] + 2 * border);
        const std::string left = mm(low[0] - border);
        const std::string top =
            mm(-(low[1] - border + (high[1] - low[1] + 2 * border)));  // y points up in the mesh, down here
        out_.append(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
            "xmlns:slic3r=\"http://slic3r.org/namespaces/slic3r\" xmlns:lamella=\"urn:lamella\" width=\"" +
            width + "mm\" height=\"" + height + "mm\" viewBox=\"" + left + " " + top + " " + width + " " + height +
            "\" fill-rule=\"nonzero\">\n");
        out_.append("<title>" + counted(layers_, "layer") + "</title>\n<desc>" + description(info, welded) + "</desc>\n");
        out_.append("<rect x=\"" + left + "\" y=\"" + top + "\" width=\"" + width + "\" height=\"" + height +
                    "\" fill=\"white\"/>\n");
    }

    void add(const LayerView& view) override {
        out_.append("<g id=\"layer" + std::to_string(view.index) + "\" slic3r:z=\"" + exact_text(view.plane_mm) +
                    "\" lamella:cut-z=\"" + exact_text(view.cut_mm()) + "\" slic3r:layer-height=\"" +
                    mm(view.top_mm - view.bottom_mm) + "\" fill=\"" + colour(view.index) +
                    "\" transform=\"scale(1,-1)\">\n");
        for (const Contour& own : view.contours) {
            contour(own, view.points_of(own));
        }
        stitches_.insert(stitches_.end(), view.stitches.begin(), view.stitches.end());
        out_.append("</g>\n");
    }

    /// Over all layers, as a warning must not be hidden by those above it: where gaps were closed, and
    /// open polylines once more.
    void finish() override {
        if (!stitches_.empty()) {
            out_.append("<g id=\"gaps\" transform=\"scale(1,-1)\" fill=\"none\" " + stroke() + ">\n<desc>" +
                        counted(stitches_.size(), "gap") + " " + stitching_ + " closed</desc>\n");
            for (const Stitch& stitch : stitches_) {
                out_.append("<polyline points=\"");
                points(std::array{stitch.from, stitch.to});
                out_.append("\"/>\n");
            }
            out_.append("</g>\n");
        }
        if (!open_.empty()) {
            out_.append("<g id=\"open\" transform=\"scale(1,-1)\">\n");
            for (const std::uint64_t contour : open_) {
                pace_.spend(1);
                out_.append("<use xlink:href=\"#open" + std::to_string(contour) + "\"/>\n");
            }
            out_.append("</g>\n");
        }
        out_.append("</svg>\n");
    }

    double rounding_mm() const noexcept override { return format_.rounding_mm(); }

private:
    static std::string description(const SliceInfo& info, const WeldedMesh* welded) {
        const SliceOptions& options = info.options;
        const std::string weld = welded == nullptr
                                     ? ""
                                     : "Vertices at most " + exact_text(welded->tolerance_mm) +
                                           " mm apart welded before: " + std::to_string(welded->joined) + " moved. ";
        return "Coordinates in mm. Grid unit " + exact_text(info.grid_mm) + " mm. " + weld +
               "Planes: " + describe_planes(options) + ". " + describe_rules(options.region) + ". " +
               describe_frame(options.frame) + ".";
    }

    /// Of lines that are warnings.
    std::string stroke() const {
        return "stroke=\"" + std::string(warning_colour) + "\" stroke-width=\"" + mm(warning_stroke * extent_) + "\"";
    }

    static std::string mm(double value) { return MmFormat().text_of_mm(value); }

    /// As "#rrggbb", from the lowest layer's to the highest's.
    std::string colour(std::uint64_t index) const {
        const std::uint64_t last = std::max<std::uint64_t>(layers_, 2) - 1;
        const double share = std::min(1.0, static_cast<double>(index) / static_cast<double>(last));
        std::string text = "#";
        for (std::size_t channel = 0; channel < 3; ++channel) {
            const int low = lowest_colour[channel];
            text += hex_text(static_cast<std::uint64_t>(low + std::lround(share * (highest_colour[channel] - low))), 2);
        }
        return text;
    }

    void contour(const Contour& contour, std::span<const Point> own_points) {
        const std::uint64_t index = contours_++;
        if (contour.role == Role::open) {
            open_.push_back(index);
            out_.append("<polyline id=\"open" + std::to_string(index) + "\" slic3r:type=\"open\" fill=\"none\" " + stroke() +
                        " points=\"");
        } else {
            out_.append(contour.role == Role::outer  ? "<polygon slic3r:type=\"contour\" points=\""
                        : contour.role == Role::hole ? "<polygon slic3r:type=\"hole\" fill=\"white\" points=\""
                                                     : "<polygon slic3r:type=\"flat\" points=\"");
        }
        points(own_points);
        out_.append((contour.flags & would_close) != 0 ? "\" class=\"near\"" : "\"");
        if (parts_ > 1) {
            out_.append(" lamella:part=\"" + (contour.part == several_parts ? "several" : std::to_string(contour.part)) +
                        "\"");
        }
        out_.append("/>\n");
    }

    void points(std::span<const Point> all) {
        constexpr std::size_t point_work = 16;  // as StopPace counts it
        constexpr std::size_t points_at_once = 1024;
        constexpr std::size_t bytes_a_point = 2 * (MmFormat::most_chars + 1);
        static_assert(points_at_once * bytes_a_point <= OutputFile::buffer_bytes);
        while (!all.empty()) {
            const std::size_t count = std::min(all.size(), points_at_once);
            char* to = out_.room(count * bytes_a_point);
            for (const Point& point : all.first(count)) {
                to = format_.write(to, point.x);
                *to++ = ',';
                to = format_.write(to, point.y);
                *to++ = ' ';
            }
            pace_.spend(point_work * count);
            all = all.subspan(count);
            out_.advance(all.empty() ? to - 1 : to);
        }
    }

    std::uint64_t layers_;
    std::uint64_t parts_;
    std::string stitching_;
    OutputFile& out_;
    MmFormat format_;
    double extent_;  ///< of the mesh in x or y, the larger one
    StopPace pace_;
    std::uint64_t contours_ = 0;  ///< written
    std::vector<std::uint64_t> open_;
    std::vector<Stitch> stitches_;
};

}  // namespace svg

std::unique_ptr<LayerWriter> make_svg(const LayerFilePlan& plan, OutputFile& out) {
    auto writer = std::make_unique<svg::SvgWriter>(plan.info, plan.context.stop, out);
    writer->head(plan.info, plan.options.welded);
    return writer;
}

}  // namespace lamella
