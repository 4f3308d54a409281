#include "lamella/medical/mask.hpp"

#include <zlib.h>

#include "base/parallel.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/text_file.hpp"
#include "medical/geometry/headers.hpp"
#include "medical/mask/slice_raster.hpp"
#include "medical/tables/csv_text.hpp"

namespace lamella {

namespace {

/// A block of slices has about so much: enough for a piece of gzip.
constexpr std::size_t block_bytes = std::size_t{1} << 20;
constexpr std::size_t blocks_a_thread = 2;

/// Some slices, and their bytes as they are written where they are compressed.
struct Block {
    std::vector<unsigned char> raw;
    std::vector<unsigned char> compressed;
    unsigned long crc = 0;  ///< of `raw`
    std::optional<MaskCounts> counts;
};

/// Makes a block of slices [begin, end), after `head`. Memory of earlier blocks serves again: fresh memory would take longer
/// than drawing. `is_last`: the block ends the gzip member.
void make(std::uint64_t begin, std::uint64_t end, std::string_view head, const SliceRaster& raster, const MaskLayout& layout,
          bool is_last, Block& block, SliceRaster::Scratch& scratch) {
    block.counts.emplace(layout.names.size());
    block.raw.resize(head.size() + (end - begin) * raster.slice_bytes());
    std::copy(head.begin(), head.end(), block.raw.begin());
    unsigned char* to = block.raw.data() + head.size();
    for (std::uint64_t slice = begin; slice < end; ++slice, to += raster.slice_bytes()) {
        raster.draw(slice, to, scratch, *block.counts);
    }
    if (layout.compressed) {
        block.compressed = gzip_piece(block.raw, is_last);
        block.crc = ::crc32_z(0, block.raw.data(), block.raw.size());
    }
}

/// Writes blocks of slices, in their order, each made on any thread.
MaskCounts write_slices(const SliceRaster& raster, const ImageGeometry& image, const MaskLayout& layout, OutputFile& file,
                        const Parallel& parallel) {
    const std::string header = mask_header(layout, image);
    // The header of compressed NIfTI is within the gzip member, that of NRRD before it.
    const bool is_within = layout.compressed && layout.form == MaskForm::nifti;
    file.append(is_within ? std::string_view() : header);
    file.append(layout.compressed ? gzip_begin : std::string_view());
    const std::uint64_t slices_a_block = std::max<std::uint64_t>(1, block_bytes / raster.slice_bytes());
    const std::uint64_t blocks = (image.size[2] + slices_a_block - 1) / slices_a_block;
    const std::size_t at_once = blocks_a_thread * static_cast<std::size_t>(parallel.threads());
    std::vector<SliceRaster::Scratch> scratch(static_cast<std::size_t>(parallel.threads()));
    std::vector<Block> made(at_once);
    MaskCounts total(layout.names.size());
    unsigned long crc = 0;
    std::uint64_t length = 0;
    for (std::uint64_t first = 0; first < blocks && !file.failed(); first += at_once) {
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(at_once, blocks - first));
        parallel.run(count, [&](std::size_t i, int worker) {
            const std::uint64_t begin = (first + i) * slices_a_block;
            const std::uint64_t end = std::min(image.size[2], begin + slices_a_block);
            make(begin, end, is_within && begin == 0 ? header : std::string_view(), raster, layout, end == image.size[2],
                 made[i], scratch[static_cast<std::size_t>(worker)]);
        });
        for (std::size_t i = 0; i < count; ++i) {
            const std::vector<unsigned char>& bytes = layout.compressed ? made[i].compressed : made[i].raw;
            file.append({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
            crc = ::crc32_combine(crc, made[i].crc, static_cast<z_off_t>(made[i].raw.size()));
            length += made[i].raw.size();
            total.add(*made[i].counts);
        }
    }
    file.append(layout.compressed ? gzip_end(crc, length) : std::string());
    return total;
}

MaskSummary summary_of(const MaskCounts& counts, std::span<const MaskPart> parts, const Context& context) {
    constexpr AuditOptions only_open{.volume = false, .ledger = false, .crossings = false};
    MaskSummary summary{counts.voxels, counts.overlapped, {}, {}, {}};
    for (std::size_t i = 0; i < counts.area.size(); ++i) {
        const OpenLayers open = *require(audit(*parts[i].result, MeshView{}, only_open, context)).open;
        summary.open.push_back(open);
        const double outside = counts.area[i] - counts.inside[i];
        // Less is rounding.
        summary.cut_off_share.push_back(outside > 1e-9 * counts.area[i] ? outside / counts.area[i] : 0);
        if (open.layers > 0 && open.layers == open.crossed) {
            summary.cut_off_share.back() = std::numeric_limits<double>::quiet_NaN();
        }
        summary.mean_wall_mm.push_back(counts.length[i] > 0 ? counts.area[i] / counts.length[i]
                                                            : std::numeric_limits<double>::quiet_NaN());
    }
    return summary;
}

/// NAME.labels.csv beside NAME.nii.gz: label, name, voxels.
Status write_label_table(std::span<const MaskPart> parts, const MaskSummary& summary, const std::filesystem::path& path) {
    std::string name = path.string();
    for (const char* end : {".gz", ".nii", ".nrrd", ".seg"}) {
        const std::string_view tail(end);
        if (name.size() > tail.size() && std::string_view(name).ends_with(tail)) {
            name.resize(name.size() - tail.size());
        }
    }
    std::string rows = "label,name,voxels\n";
    for (std::size_t i = 0; i < parts.size(); ++i) {
        rows += std::to_string(i + 1) + "," + csv_text(text_of_name(parts[i].name)) + "," +
                std::to_string(summary.voxels[i]) + "\n";
    }
    return write_text_file(name + ".labels.csv", rows);
}

}  // namespace

Result<MaskSummary> write_mask(std::span<const MaskPart> parts, const ImageGeometry& image,
                               const std::filesystem::path& path, const MaskOptions& options,
                               const Context& context) noexcept {
    return guarded(context, [&]() -> Result<MaskSummary> {
        const MaskLayout layout = layout_of(path, parts, options.coverage || options.subslices > 1);
        require_mask_fits(path, layout, image);
        if (options.subslices < 1) {
            refuse_output(path, "a slice has at least one plane");
        }
        for (const MaskPart& part : parts) {
            require_cut(part.result, part.name, image.size[2] * static_cast<std::uint64_t>(options.subslices));
        }
        const SliceRaster raster(parts, image, options, layout);
        const Parallel parallel(context);
        OutputFile file = require(OutputFile::create(path));
        const MaskCounts counts = write_slices(raster, image, layout, file, parallel);
        const MaskSummary summary = summary_of(counts, parts, parallel.within(context));
        require(file.commit());
        if (parts.size() > 1) {
            require(write_label_table(parts, summary, path));
        }
        return summary;
    });
}

}  // namespace lamella
