// 3MF with the slice extension 1.0.2: an object a part, its layers a slice stack, its mesh a box in their place. Stacks
// stand before objects, one after another, though their layers come side by side: they are put aside, and packed in the end.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/words.hpp"
#include "io/layers/layer_writer.hpp"
#include "io/layers/spill.hpp"
#include "io/layers/zip_writer.hpp"
#include "io/text/mm_text.hpp"
#include "lamella/io/name_text.hpp"

namespace lamella {

namespace {

constexpr std::string_view content_types =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Types "
    "xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">"
    "<Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>"
    "<Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>\n";
constexpr std::string_view relations =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Relationships "
    "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Target=\"/3D/3dmodel.model\" "
    "Id=\"rel0\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>\n";
constexpr std::string_view model_head =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" "
    "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
    "xmlns:s=\"http://schemas.microsoft.com/3dmanufacturing/slice/2015/07\" requiredextensions=\"s\">\n<resources>\n";

std::string attribute_text(const std::string& text) {
    std::string escaped;
    for (const char c : printable(text)) {
        c == '&' ? escaped += "&amp;" : c == '<' ? escaped += "&lt;" : c == '"' ? escaped += "&quot;" : escaped += c;
    }
    return escaped;
}

std::string mesh_of(const Box& box) {
    constexpr std::string_view corners = "023 031 457 476 015 054 267 273 046 062 137 175";
    std::string text = "<mesh><vertices>";
    for (std::size_t corner = 0; corner < 8; ++corner) {
        const auto at = [&](std::size_t axis) {
            return exact_text(((corner >> axis & 1) == 0 ? box.min_mm : box.max_mm)[axis]);
        };
        text += "<vertex x=\"" + at(0) + "\" y=\"" + at(1) + "\" z=\"" + at(2) + "\"/>";
    }
    text += "</vertices><triangles>";
    for (std::size_t at = 0; at < corners.size(); at += 4) {
        text += std::string("<triangle v1=\"") + corners[at] + "\" v2=\"" + corners[at + 1] + "\" v3=\"" + corners[at + 2] +
                "\"/>";
    }
    return text + "</triangles></mesh>";
}

class SliceStackWriter final : public LayerWriter {
public:
    SliceStackWriter(const LayerFilePlan& plan, OutputFile& out)
        : plan_(plan),
          parts_(std::max<std::uint64_t>(1, plan.info.part_count)),
          format_(plan.info.grid_mm),
          columns_(plan.path, parts_ + 2, plan.context.stop),
          zip_(out) {}

    void add(const LayerView& layer) override {
        if (!(static_cast<float>(layer.top_mm) > static_cast<float>(top_mm_))) {
            throw Refused{{ErrorCode::invalid_argument, "'" + plan_.name + "': the layers up to z = " + exact_text(top_mm_) +
                                                            " and " + exact_text(layer.top_mm) +
                                                            " mm do not ascend as 32-bit floats, which 3mf-slices needs"}};
        }
        bottom_mm_ = std::isinf(top_mm_) ? layer.bottom_mm : bottom_mm_;
        top_mm_ = layer.top_mm;
        contours_.clear();
        for (const Contour& contour : layer.contours) {
            if (contour.encloses_area()) {
                contours_.push_back(&contour);
            }
        }
        std::stable_sort(contours_.begin(), contours_.end(),
                         [](const Contour* a, const Contour* b) { return a->part < b->part; });
        const Contour* const* begin = contours_.data();
        const Contour* const* const all = begin + contours_.size();
        for (std::uint64_t part = 0; part <= parts_; ++part) {
            const auto is_own = [&](const Contour* contour) {
                return std::min<std::uint64_t>(contour->part, parts_) == part;
            };
            const Contour* const* const end = std::find_if_not(begin, all, is_own);
            slice(layer, {begin, static_cast<std::size_t>(end - begin)}, part);
            begin = end;
        }
    }

    void finish() override {
        std::string objects;
        std::string items;
        std::uint64_t id = 0;
        pack(model_head);
        for (std::uint64_t part = 0; part < parts_ + (any_of_several_ ? 1 : 0); ++part) {
            const std::string stack = std::to_string(++id);
            const std::string object = std::to_string(++id);
            pack("<s:slicestack id=\"" + stack + "\" zbottom=\"" + exact_text(bottom_mm_) + "\">\n");
            columns_.read(part, [&](std::string_view piece) { pack(piece); });
            pack("</s:slicestack>\n");
            objects.append("<object id=\"").append(object).append("\" type=\"model\" name=\"");
            objects.append(attribute_text(part < parts_ ? plan_.part_name(part) : "several parts"));
            objects.append("\" s:slicestackid=\"").append(stack).append("\" s:meshresolution=\"lowres\">");
            objects.append(mesh_of(plan_.info.box)).append("</object>\n");
            items += "<item objectid=\"" + object + "\"/>\n";
        }
        pack(objects + "</resources>\n<build>\n" + items + "</build>\n</model>\n", Z_FINISH);
        zip_.add("[Content_Types].xml", content_types);
        zip_.add("_rels/.rels", relations);
        zip_.begin("3D/3dmodel.model", ZipWriter::deflated, deflate_.checksum, deflate_.bytes, columns_.bytes(parts_ + 1));
        columns_.read(parts_ + 1, [&](std::string_view piece) { zip_.write(piece); });
        zip_.finish();
    }

    double rounding_mm() const noexcept override { return format_.rounding_mm(); }

private:
    /// What a part has in a layer; `parts_`: what comes of several.
    void slice(const LayerView& layer, std::span<const Contour* const> contours, std::uint64_t part) {
        std::string vertices;
        std::string polygons;
        std::uint64_t first = 0;
        for (const Contour* const contour : contours) {
            polygons += "<s:polygon startv=\"" + std::to_string(first) + "\">";
            std::uint64_t next = 0;
            for (const Point point : layer.points_of(*contour)) {
                vertices += "<s:vertex x=\"";
                format_.append_to(vertices, point.x);
                vertices += "\" y=\"";
                format_.append_to(vertices, point.y);
                vertices += "\"/>";
                polygons += "<s:segment v2=\"" + std::to_string(first + ++next % contour->point_count) + "\"/>";
            }
            polygons += "</s:polygon>";
            first += contour->point_count;
        }
        any_of_several_ = any_of_several_ || (part == parts_ && first > 0);
        columns_.append(part, "<s:slice ztop=\"" + exact_text(layer.top_mm) + (first == 0 ? "\"/>\n" : "\"><s:vertices>"));
        if (first > 0) {
            columns_.append(part, vertices.append("</s:vertices>").append(polygons).append("</s:slice>\n"));
        }
    }

    /// Appends to the column of what is packed.
    void pack(std::string_view text, int flush = Z_NO_FLUSH) {
        z_stream& stream = deflate_.stream;
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // NOLINT: it is only read
        stream.avail_in = static_cast<uInt>(text.size());
        deflate_.checksum = static_cast<std::uint32_t>(crc32_z(deflate_.checksum, stream.next_in, text.size()));
        deflate_.bytes += text.size();
        std::array<char, 1 << 16> room;
        do {
            stream.next_out = reinterpret_cast<Bytef*>(room.data());
            stream.avail_out = static_cast<uInt>(room.size());
            (void)deflate(&stream, flush);
            columns_.append(parts_ + 1, {room.data(), room.size() - stream.avail_out});
        } while (stream.avail_out == 0);
    }

    struct Deflate {
        Deflate() {
            if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, -MAX_WBITS, MAX_MEM_LEVEL, Z_DEFAULT_STRATEGY) != Z_OK) {
                throw std::bad_alloc();
            }
        }
        Deflate(const Deflate&) = delete;
        Deflate& operator=(const Deflate&) = delete;
        ~Deflate() { (void)deflateEnd(&stream); }

        z_stream stream{};
        std::uint32_t checksum = 0;
        std::uint64_t bytes = 0;
    };

    LayerFilePlan plan_;
    std::uint64_t parts_;
    MmFormat format_;
    double bottom_mm_ = 0;
    double top_mm_ = -std::numeric_limits<double>::infinity();
    bool any_of_several_ = false;
    std::vector<const Contour*> contours_;  ///< of a layer, by part
    Spill columns_;                         ///< a stack a part, that of several, and all of it packed
    Deflate deflate_;
    ZipWriter zip_;
};

}  // namespace

std::unique_ptr<LayerWriter> make_slice_stack(const LayerFilePlan& plan, OutputFile& out) {
    return std::make_unique<SliceStackWriter>(plan, out);
}

}  // namespace lamella
