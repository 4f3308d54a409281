#include "lamella/medical/mask.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "medical/geometry/directions.hpp"
#include "medical/mask/mask_file.hpp"
#include "medical/raster/centres.hpp"
#include "medical/raster/coverage.hpp"
#include "medical/raster/row_crossings.hpp"

namespace lamella {

namespace {

/// What a block of slices is about: enough for a piece of gzip.
constexpr std::size_t block_bytes = std::size_t{1} << 20;

/// Of a thread, or of all.
struct Counts {
    std::vector<std::uint64_t> voxels;
    std::uint64_t overlapped = 0;
    std::uint64_t open_slices = 0;
    std::vector<double> area;    ///< of each part, in square voxels
    std::vector<double> inside;  ///< of it, what lies within the image

    explicit Counts(std::size_t parts) : voxels(parts), area(parts), inside(parts) {}
    void add(const Counts& other) {
        overlapped += other.overlapped;
        open_slices += other.open_slices;
        for (std::size_t i = 0; i < voxels.size(); ++i) {
            voxels[i] += other.voxels[i];
            area[i] += other.area[i];
            inside[i] += other.inside[i];
        }
    }
};

/// Twice the area of a polygon.
double twice_area(const std::vector<PointMm>& polygon) {
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const PointMm& a = polygon[i];
        const PointMm& b = polygon[(i + 1) % polygon.size()];
        sum += a.x * b.y - b.x * a.y;
    }
    return sum;
}

/// Keeps what of a polygon lies on one side of a line x = limit or y = limit (Sutherland and Hodgman): its area is right,
/// whatever its form.
std::vector<PointMm> clipped(const std::vector<PointMm>& polygon, bool along_y, double limit, double side) {
    const auto beyond = [&](const PointMm& at) { return side * ((along_y ? at.y : at.x) - limit); };
    std::vector<PointMm> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const PointMm& a = polygon[i];
        const PointMm& b = polygon[(i + 1) % polygon.size()];
        const double from = beyond(a);
        const double to = beyond(b);
        if (from <= 0) {
            kept.push_back(a);
        }
        if ((from < 0 && to > 0) || (from > 0 && to < 0)) {
            const double t = from / (from - to);
            kept.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
        }
    }
    return kept;
}

/// Voxels of one slice after the other.
class SliceRaster {
public:
    SliceRaster(std::span<const MaskPart> parts, const ImageGeometry& image, const MaskOptions& options,
                const MaskLayout& layout)
        : parts_(parts), image_(image), options_(options), layout_(layout) {
        for (const MaskPart& part : parts) {
            columns_.emplace_back(image.size[0], image.spacing_mm[0], part.result->unit_mm);
            rows_.emplace_back(image.size[1], image.spacing_mm[1], part.result->unit_mm);
        }
    }

    std::size_t slice_bytes() const noexcept { return image_.size[0] * image_.size[1] * layout_.voxel_bytes; }

    /// What one thread works with.
    struct Scratch {
        RowCrossings crossings;
        CoverageSheet sheet;
        std::vector<double> shares;
        std::vector<std::uint16_t> wide;  ///< labels of a slice, before they become bytes
    };

    void draw(std::uint64_t slice, unsigned char* to, Scratch& scratch, Counts& counts) const {
        std::memset(to, 0, slice_bytes());
        bool open = false;
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            for (int subslice = 0; subslice < options_.subslices; ++subslice) {
                open = measure(i, layer(i, slice, subslice), counts) || open;
            }
        }
        counts.open_slices += open ? 1 : 0;
        if (layout_.shares) {
            draw_shares(slice, to, scratch, counts);
        } else if (layout_.voxel_bytes == 1) {
            draw_labels(slice, to, scratch, counts);
        } else {
            draw_wide_labels(slice, to, scratch, counts);
        }
    }

private:
    const Layer& layer(std::size_t part, std::uint64_t slice, int subslice) const {
        const SliceResult& result = *parts_[part].result;
        const std::uint64_t height =
            slice * static_cast<std::uint64_t>(options_.subslices) + static_cast<std::uint64_t>(subslice);
        return result.layers[result.layer_of[height]];
    }

    /// Adds the areas of a layer; whether it has open polylines.
    bool measure(std::size_t part, const Layer& layer, Counts& counts) const {
        const SliceResult& result = *parts_[part].result;
        const double scale[2] = {result.unit_mm / image_.spacing_mm[0], result.unit_mm / image_.spacing_mm[1]};
        const double limit[2] = {static_cast<double>(image_.size[0]) - 0.5, static_cast<double>(image_.size[1]) - 0.5};
        bool open = false;
        for (const Contour& contour : result.contours_of(layer)) {
            open = open || contour.role == Role::open;
            if (contour.role != Role::outer && contour.role != Role::hole) {
                continue;
            }
            std::vector<PointMm> polygon;
            bool beside = false;
            for (const Point& point : result.points_of(contour)) {
                const PointMm at{point.x * scale[0], point.y * scale[1]};
                beside = beside || at.x < -0.5 || at.y < -0.5 || at.x > limit[0] || at.y > limit[1];
                polygon.push_back(at);
            }
            const double area = 0.5 * twice_area(polygon);
            counts.area[part] += area;
            if (beside) {
                for (const bool along_y : {false, true}) {
                    polygon = clipped(clipped(polygon, along_y, -0.5, -1), along_y, limit[along_y ? 1 : 0], 1);
                }
                counts.inside[part] += 0.5 * twice_area(polygon);
            } else {
                counts.inside[part] += area;
            }
        }
        return open;
    }

    template <class Label>
    void draw_spans(std::uint64_t slice, Label* to, Scratch& scratch, Counts& counts) const {
        RowCrossings& crossings = scratch.crossings;
        crossings.restart(0, image_.size[1]);
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const SliceResult& result = *parts_[i].result;
            for (const Contour& contour : result.contours_of(layer(i, slice, 0))) {
                if (contour.role != Role::open) {
                    crossings.add(result.points_of(contour), columns_[i], rows_[i], static_cast<std::uint32_t>(i));
                }
            }
        }
        crossings.sort();
        for (std::size_t row = 0; row < image_.size[1]; ++row) {
            Label* const voxels = to + row * image_.size[0];
            std::span<const Crossing> of_row = crossings.of_row(row);
            while (!of_row.empty()) {
                const std::uint32_t part = of_row.front().part();
                const auto end = std::find_if(of_row.begin(), of_row.end(),
                                              [part](const Crossing& crossing) { return crossing.part() != part; });
                const auto count = static_cast<std::size_t>(end - of_row.begin());
                for_each_span(of_row.first(count), image_.size[0], [&](std::size_t first, std::size_t last) {
                    fill(voxels + first, voxels + last, part, counts);
                });
                of_row = of_row.subspan(count);
            }
        }
    }

    template <class Label>
    void fill(Label* begin, Label* end, std::uint32_t part, Counts& counts) const {
        if (part > 0) {
            for (const Label* voxel = begin; voxel != end; ++voxel) {
                if (*voxel != 0) {
                    --counts.voxels[*voxel - 1U];
                    ++counts.overlapped;
                }
            }
        }
        std::fill(begin, end, static_cast<Label>(part + 1));
        counts.voxels[part] += static_cast<std::uint64_t>(end - begin);
    }

    void draw_labels(std::uint64_t slice, unsigned char* to, Scratch& scratch, Counts& counts) const {
        draw_spans(slice, to, scratch, counts);
    }

    void draw_wide_labels(std::uint64_t slice, unsigned char* to, Scratch& scratch, Counts& counts) const {
        scratch.wide.assign(image_.size[0] * image_.size[1], 0);
        draw_spans(slice, scratch.wide.data(), scratch, counts);
        for (const std::uint16_t label : scratch.wide) {
            *to++ = static_cast<unsigned char>(label & 0xff);
            *to++ = static_cast<unsigned char>(label >> 8);
        }
    }

    void draw_shares(std::uint64_t slice, unsigned char* to, Scratch& scratch, Counts& counts) const {
        const SliceResult& result = *parts_[0].result;
        const std::size_t width = image_.size[0];
        const double scale[2] = {result.unit_mm / image_.spacing_mm[0], result.unit_mm / image_.spacing_mm[1]};
        scratch.shares.assign(width * image_.size[1], 0);
        for (int subslice = 0; subslice < options_.subslices; ++subslice) {
            scratch.sheet.restart(width, 0, image_.size[1]);
            for (const Contour& contour : result.contours_of(layer(0, slice, subslice))) {
                if (contour.role != Role::open) {
                    scratch.sheet.add(result.points_of(contour), scale);
                }
            }
            for (std::size_t row = 0; row < image_.size[1]; ++row) {
                scratch.sheet.take_row(row, std::span(scratch.shares).subspan(row * width, width));
            }
        }
        for (const double share : scratch.shares) {
            *to = static_cast<unsigned char>(std::lround(255 * share / options_.subslices));
            counts.voxels[0] += *to++ != 0 ? 1 : 0;
        }
    }

    std::span<const MaskPart> parts_;
    const ImageGeometry& image_;
    const MaskOptions& options_;
    const MaskLayout& layout_;
    std::vector<Centres> columns_;  ///< of each part, whose grids may differ
    std::vector<Centres> rows_;
};

void require_slices(std::span<const MaskPart> parts, const ImageGeometry& image, const MaskOptions& options) {
    if (options.subslices < 1) {
        throw Refused{{ErrorCode::invalid_argument, "a slice has at least one plane"}};
    }
    for (const MaskPart& part : parts) {
        if (part.result == nullptr ||
            part.result->layer_of.size() != image.size[2] * static_cast<std::uint64_t>(options.subslices)) {
            throw Refused{{ErrorCode::invalid_argument, "'" + part.name + "' was not cut at the slices of the image"}};
        }
    }
}

/// Quoted for CSV where it has to be.
std::string quoted(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) {
        return text;
    }
    std::string all = "\"";
    for (const char c : text) {
        all += c == '"' ? "\"\"" : std::string(1, c);
    }
    return all + "\"";
}

Status write_label_table(std::span<const MaskPart> parts, const MaskSummary& summary, const std::filesystem::path& path) {
    std::string name = path.string();
    for (const char* end : {".gz", ".nii", ".nrrd", ".seg"}) {
        const std::string_view tail(end);
        if (name.size() > tail.size() && std::string_view(name).ends_with(tail)) {
            name.resize(name.size() - tail.size());
        }
    }
    Result<OutputFile> file = OutputFile::create(name + ".labels.csv");
    if (!file) {
        return file.error();
    }
    file->append("label,name,voxels\n");
    for (std::size_t i = 0; i < parts.size(); ++i) {
        file->append(std::to_string(i + 1) + "," + quoted(parts[i].name) + "," + std::to_string(summary.voxels[i]) + "\n");
    }
    return file->commit();
}

/// Blocks of slices are drawn, and compressed, by all threads, and written in their order.
Counts write_voxels(const SliceRaster& raster, const ImageGeometry& image, const MaskLayout& layout, std::size_t parts,
                    const Parallel& parallel, OutputFile& file) {
    const std::uint64_t slices = image.size[2];
    const std::uint64_t per_block = std::max<std::uint64_t>(1, block_bytes / raster.slice_bytes());
    const std::uint64_t blocks = (slices + per_block - 1) / per_block;
    const std::size_t at_once = 2 * static_cast<std::size_t>(parallel.threads());
    std::vector<SliceRaster::Scratch> scratch(static_cast<std::size_t>(parallel.threads()));
    std::vector<std::vector<unsigned char>> voxels(at_once);
    std::vector<GzipPiece> pieces(at_once);
    std::optional<GzipMember> member;
    if (layout.compressed) {
        member.emplace(file);
        if (layout.form == MaskForm::nifti) {
            const std::string header = mask_header(layout, image);
            member->append(gzip_piece({reinterpret_cast<const unsigned char*>(header.data()), header.size()}, false));
        }
    }
    Counts total(parts);
    for (std::uint64_t first = 0; first < blocks && !file.failed(); first += at_once) {
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(at_once, blocks - first));
        std::vector<Counts> counts(count, Counts(parts));
        parallel.run(count, [&](std::size_t i, int worker) {
            const std::uint64_t begin = (first + i) * per_block;
            const std::uint64_t end = std::min(slices, begin + per_block);
            voxels[i].resize((end - begin) * raster.slice_bytes());
            for (std::uint64_t slice = begin; slice < end; ++slice) {
                raster.draw(slice, voxels[i].data() + (slice - begin) * raster.slice_bytes(),
                            scratch[static_cast<std::size_t>(worker)], counts[i]);
            }
            if (layout.compressed) {
                pieces[i] = gzip_piece(voxels[i], end == slices);
            }
        });
        for (std::size_t i = 0; i < count; ++i) {
            if (member) {
                member->append(pieces[i]);
            } else {
                file.append({reinterpret_cast<const char*>(voxels[i].data()), voxels[i].size()});
            }
            total.add(counts[i]);
        }
    }
    if (member) {
        member->end();
    }
    return total;
}

}  // namespace

Result<MaskSummary> write_mask(std::span<const MaskPart> parts, const ImageGeometry& image,
                               const std::filesystem::path& path, const MaskOptions& options) noexcept {
    return guarded(options.control, [&]() -> Result<MaskSummary> {
        const MaskLayout layout = layout_of(path, parts, options.coverage || options.subslices > 1);
        require_mask_fits(path, layout, image);
        require_slices(parts, image, options);
        const SliceRaster raster(parts, image, options, layout);
        Parallel parallel(options.control);
        parallel.follow(options.control.stop);
        Result<OutputFile> file = OutputFile::create(path);
        if (!file) {
            return file.error();
        }
        if (!layout.compressed || layout.form != MaskForm::nifti) {
            file->append(mask_header(layout, image));
        }
        const Counts counts = write_voxels(raster, image, layout, parts.size(), parallel, *file);
        if (const Status written = file->commit(); !written) {
            return written.error();
        }
        MaskSummary summary{counts.voxels, counts.overlapped, counts.open_slices, {}};
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const double outside = counts.area[i] - counts.inside[i];
            // What rounding leaves of nothing is nothing.
            summary.cut_off_share.push_back(outside > 1e-9 * counts.area[i] ? outside / counts.area[i] : 0);
        }
        if (parts.size() > 1) {
            if (const Status written = write_label_table(parts, summary, path); !written) {
                return written.error();
            }
        }
        return summary;
    });
}

}  // namespace lamella
