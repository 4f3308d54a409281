// GeoJSON (RFC 7946): a Feature a layer and part, its MultiPolygon; open contours and those without area are a
// MultiLineString beside it. Coordinates are mm, which a member "unit" says: readers take them for degrees unless told.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "base/words.hpp"
#include "io/layers/layer_writer.hpp"
#include "io/text/mm_text.hpp"
#include "io/write/json.hpp"

namespace lamella {

namespace {

class GeoJsonWriter final : public LayerWriter {
public:
    GeoJsonWriter(const LayerFilePlan& plan, OutputFile& out) : plan_(plan), format_(plan.info.grid_mm), out_(out) {
        pace_.follow(plan.context.stop);
        out_.append("{\"type\":\"FeatureCollection\",\"unit\":\"mm\",\"features\":[");
    }

    void add(const LayerView& layer) override {
        const Islands islands = layer.islands();
        items_.assign(islands.begin(), islands.end());
        for (const Contour& contour : layer.contours) {
            if (!contour.encloses_area()) {
                items_.push_back({&contour, {}});
            }
        }
        const auto key = [](const Island& item) { return std::pair(item.outer->part, !item.outer->encloses_area()); };
        std::stable_sort(items_.begin(), items_.end(), [&](const Island& a, const Island& b) { return key(a) < key(b); });
        for (std::size_t i = 0; i < items_.size(); ++i) {
            const bool is_new = i == 0 || key(items_[i - 1]) != key(items_[i]);
            if (is_new) {
                begin_feature(layer, *items_[i].outer);
            }
            shape(layer, items_[i], is_new);
            if (i + 1 == items_.size() || key(items_[i + 1]) != key(items_[i])) {
                end_feature();
            }
        }
        if (items_.empty()) {
            begin_feature(layer, {});
            end_feature();
        }
    }

    void finish() override { out_.append("\n]}\n"); }
    double rounding_mm() const noexcept override { return format_.rounding_mm(); }

private:
    void begin_feature(const LayerView& layer, const Contour& first) {
        text_ += is_first_ ? "\n" : ",\n";
        is_first_ = false;
        text_ += "{\"type\":\"Feature\",\"properties\":{\"layer\":" + std::to_string(plan_.info.first_layer + layer.index) +
                 ",\"z\":" + exact_text(layer.plane_mm) + ",\"bottom\":" + exact_text(layer.bottom_mm) +
                 ",\"top\":" + exact_text(layer.top_mm) + ",\"kind\":\"" + (first.encloses_area() ? "solid" : "lines") +
                 "\"";
        if (plan_.info.part_count > 1) {
            JsonText name;
            name.value(plan_.part_name(first.part));
            const std::string quoted = std::move(name).take();
            text_ += ",\"part\":" + std::to_string(first.part) + ",\"name\":" + quoted.substr(0, quoted.size() - 1);
        }
        text_ += std::string("},\"geometry\":{\"type\":\"") + (first.encloses_area() ? "MultiPolygon" : "MultiLineString") +
                 "\",\"coordinates\":[";
    }

    void shape(const LayerView& layer, const Island& item, bool is_first) {
        text_ += is_first ? "" : ",";
        if (!item.outer->encloses_area()) {
            return ring(layer, *item.outer);
        }
        text_ += "[";
        ring(layer, *item.outer);
        for (const Contour& hole : item.holes) {
            text_ += ",";
            ring(layer, hole);
        }
        text_ += "]";
    }

    void end_feature() {
        text_ += "]}}";
        out_.append(text_);
        text_.clear();
    }

    void ring(const LayerView& layer, const Contour& contour) {
        const std::span<const Point> points = layer.points_of(contour);
        text_ += "[";
        for (const Point& point : points) {
            position(point, &point == points.data());
        }
        if (contour.role != Role::open) {
            position(points.front(), false);
        }
        text_ += "]";
        pace_.spend(16 * points.size());
    }

    void position(Point point, bool is_first) {
        text_ += is_first ? "[" : ",[";
        format_.append_to(text_, point.x);
        text_ += ",";
        format_.append_to(text_, point.y);
        text_ += "]";
    }

    LayerFilePlan plan_;
    MmFormat format_;
    OutputFile& out_;
    StopPace pace_;
    bool is_first_ = true;
    std::string text_;  ///< of a feature
    std::vector<Island> items_;
};

}  // namespace

std::unique_ptr<LayerWriter> make_geojson(const LayerFilePlan& plan, OutputFile& out) {
    return std::make_unique<GeoJsonWriter>(plan, out);
}

}  // namespace lamella
