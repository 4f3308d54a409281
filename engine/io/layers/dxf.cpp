// DXF R12, which every reader takes: a closed or open POLYLINE a contour, at the height of its plane, on a layer "Z00124" of
// its own slice, "Z00124_HOLE" of its holes; of several parts "Z00124_P2_HOLE".
#include <array>
#include <string>

#include "base/words.hpp"
#include "io/layers/layer_writer.hpp"
#include "io/text/mm_text.hpp"

namespace lamella {

namespace {

class DxfWriter final : public LayerWriter {
public:
    DxfWriter(const LayerFilePlan& plan, OutputFile& out)
        : parts_(plan.info.part_count), first_(plan.info.first_layer), format_(plan.info.grid_mm), out_(out) {
        pace_.follow(plan.context.stop);
        out_.append("0\nSECTION\n2\nENTITIES\n");
    }

    void add(const LayerView& layer) override {
        const std::string z = "30\n" + MmFormat().text_of_mm(layer.plane_mm) + "\n";
        for (const Contour& contour : layer.contours) {
            const std::span<const Point> points = layer.points_of(contour);
            const std::string on = "8\n" + name_of_layer(layer.index, contour) + "\n";
            text_.assign("0\nPOLYLINE\n").append(on).append("66\n1\n70\n");
            text_.append(contour.role == Role::open ? "0" : "1").append("\n10\n0\n20\n0\n").append(z);
            for (const Point point : points) {
                text_.append("0\nVERTEX\n").append(on).append("10\n");
                format_.append_to(text_, point.x);
                text_ += "\n20\n";
                format_.append_to(text_, point.y);
                text_.append("\n").append(z);
            }
            text_.append("0\nSEQEND\n").append(on);
            pace_.spend(16 * points.size());
            out_.append(text_);
        }
    }

    void finish() override { out_.append("0\nENDSEC\n0\nEOF\n"); }
    double rounding_mm() const noexcept override { return format_.rounding_mm(); }

private:
    std::string name_of_layer(std::uint64_t index, const Contour& contour) const {
        constexpr std::size_t digits = 5;
        constexpr std::array<const char*, 4> suffixes = {"", "_HOLE", "_FLAT", "_OPEN"};
        const std::string number = std::to_string(first_ + index);
        const std::string part = parts_ <= 1                     ? ""
                                 : contour.part == several_parts ? "_SEVERAL"
                                                                 : "_P" + std::to_string(contour.part + 1);
        return "Z" + std::string(digits - std::min(digits, number.size()), '0') + number + part +
               suffixes[static_cast<std::size_t>(contour.role)];
    }

    std::uint64_t parts_;
    std::uint64_t first_;
    MmFormat format_;
    OutputFile& out_;
    StopPace pace_;
    std::string text_;
};

}  // namespace

std::unique_ptr<LayerWriter> make_dxf(const LayerFilePlan& plan, OutputFile& out) {
    return std::make_unique<DxfWriter>(plan, out);
}

}  // namespace lamella
