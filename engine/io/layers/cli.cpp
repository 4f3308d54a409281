// Common Layer Interface 2.0: the header as text, layers as text or as binary in its long forms, little-endian. z is a
// layer's upper surface; an empty layer below the first tells how high that is.
//
//     $$LAYER/0.2                              127, z
//     $$POLYLINE/1,1,5,0,0,10,0,10,10,...      130, label, direction, points, x, y, ...      a closed one ends where it
//     began
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "base/little_endian.hpp"
#include "base/words.hpp"
#include "io/layers/layer_writer.hpp"
#include "io/text/mm_text.hpp"

namespace lamella {

namespace {

enum class CliDirection : std::int32_t { inner = 0, outer = 1, open = 2 };

/// A contour that encloses nothing is a line.
CliDirection direction_of(const Contour& contour) noexcept {
    return contour.role == Role::outer  ? CliDirection::outer
           : contour.role == Role::hole ? CliDirection::inner
                                        : CliDirection::open;
}

/// As all readers take it: they end labels at commas, and take two slashes for a comment.
std::string label_text(std::string text) {
    for (char& c : text) {
        const bool stays = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ' ' ||
                           c == '.' || c == '_' || c == '-';
        c = stays ? c : '_';
    }
    return text;
}

class CliWriter : public LayerWriter {
public:
    CliWriter(const LayerFilePlan& plan, OutputFile& out, std::string_view mode)
        : parts_(std::max<std::uint64_t>(1, plan.info.part_count)), out_(out) {
        pace_.follow(plan.context.stop);
        const MmFormat mm;
        const auto& [low, high] = plan.info.box;
        std::string dimension;
        for (const auto& corner : {low, high}) {
            for (const double at : corner) {
                dimension += (dimension.empty() ? "" : ",") + mm.text_of_mm(at);
            }
        }
        std::string head = "$$HEADERSTART\n$$" + std::string(mode) + "\n$$UNITS/1\n$$VERSION/200\n";
        for (std::uint64_t part = 0; part < parts_; ++part) {
            const std::string name = plan.part_name(part);
            const std::string label = label_text(name);
            names_changed_ += label == name ? 0 : 1;
            head += "$$LABEL/" + std::to_string(part + 1) + "," + label + "\n";
        }
        head += "$$DIMENSION/" + dimension + "\n$$LAYERS/" +
                std::to_string(plan.info.layers == 0 ? 0 : plan.info.layers + 1) + "\n$$HEADEREND";
        out_.append(head);
    }

    void add(const LayerView& layer) override {
        if (is_first_) {
            begin_layer(layer.bottom_mm);
            is_first_ = false;
        }
        begin_layer(layer.top_mm);
        for (const Contour& contour : layer.contours) {
            std::span<const Point> points = layer.points_of(contour);
            closed_.assign(points.begin(), points.end());
            if (contour.role != Role::open) {
                closed_.push_back(points.front());
            }
            pace_.spend(16 * closed_.size());
            polyline(label_of(contour), direction_of(contour), closed_);
        }
    }

    std::uint64_t names_changed() const noexcept override { return names_changed_; }

protected:
    virtual void begin_layer(double z_mm) = 0;
    virtual void polyline(std::uint64_t label, CliDirection direction, std::span<const Point> points) = 0;

    /// What comes of several parts has a label of its own.
    std::uint64_t label_of(const Contour& contour) const noexcept {
        return std::min<std::uint64_t>(contour.part, parts_) + 1;
    }

    std::uint64_t parts_;
    OutputFile& out_;

private:
    std::uint64_t names_changed_ = 0;
    bool is_first_ = true;
    StopPace pace_;
    std::vector<Point> closed_;
};

class CliTextWriter final : public CliWriter {
public:
    CliTextWriter(const LayerFilePlan& plan, OutputFile& out) : CliWriter(plan, out, "ASCII"), format_(plan.info.grid_mm) {
        out_.append("\n$$GEOMETRYSTART\n");
    }

    void finish() override { out_.append("$$GEOMETRYEND\n"); }
    double rounding_mm() const noexcept override { return format_.rounding_mm(); }

private:
    void begin_layer(double z_mm) override { out_.append("$$LAYER/" + MmFormat().text_of_mm(z_mm) + "\n"); }

    void polyline(std::uint64_t label, CliDirection direction, std::span<const Point> points) override {
        out_.append("$$POLYLINE/" + std::to_string(label) + "," + std::to_string(static_cast<int>(direction)) + "," +
                    std::to_string(points.size()));
        for (const Point point : points) {
            char* to = out_.room(2 * MmFormat::most_chars + 2);
            *to++ = ',';
            to = format_.write(to, point.x);
            *to++ = ',';
            out_.advance(format_.write(to, point.y));
        }
        out_.append("\n");
    }

    const MmFormat format_;
};

class CliBinaryWriter final : public CliWriter {
public:
    CliBinaryWriter(const LayerFilePlan& plan, OutputFile& out)
        : CliWriter(plan, out, "BINARY"), grid_mm_(plan.info.grid_mm) {}

    void finish() override {}
    double rounding_mm() const noexcept override { return rounding_mm_; }

private:
    static constexpr std::uint16_t layer_code = 127;
    static constexpr std::uint16_t polyline_code = 130;

    template <class Number>
    void put(Number number) {
        char* const to = out_.room(sizeof number);
        std::memcpy(to, &number, sizeof number);
        out_.advance(to + sizeof number);
    }
    void put_mm(double mm) {
        const auto written = static_cast<float>(mm);
        rounding_mm_ = std::max(rounding_mm_, std::abs(static_cast<double>(written) - mm));
        put(written);
    }

    void begin_layer(double z_mm) override {
        put(layer_code);
        put_mm(z_mm);
    }

    void polyline(std::uint64_t label, CliDirection direction, std::span<const Point> points) override {
        put(polyline_code);
        put(static_cast<std::int32_t>(label));
        put(direction);
        put(static_cast<std::int32_t>(points.size()));
        for (const Point point : points) {
            put_mm(point.x * grid_mm_);
            put_mm(point.y * grid_mm_);
        }
    }

    const double grid_mm_;
    double rounding_mm_ = 0;
};

}  // namespace

std::unique_ptr<LayerWriter> make_cli(const LayerFilePlan& plan, OutputFile& out) {
    return std::make_unique<CliBinaryWriter>(plan, out);
}

std::unique_ptr<LayerWriter> make_cli_text(const LayerFilePlan& plan, OutputFile& out) {
    return std::make_unique<CliTextWriter>(plan, out);
}

}  // namespace lamella
