#include "lamella/medical/mask.hpp"

#include <array>
#include <memory>

#include <zlib.h>

#include "base/parallel.hpp"
#include "base/system/file.hpp"
#include "io/text/text.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/text_file.hpp"
#include "medical/geometry/common.hpp"
#include "medical/mask/mask_headers.hpp"
#include "medical/mask/mask_layers.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella {

namespace {

// --- the size

constexpr std::uint64_t largest_nifti_side = 32767;
constexpr std::uint64_t largest_mask_bytes = std::uint64_t{1} << 38;

/// Throws Refused where the format, or any, does not hold a mask of that size.
void require_mask_fits(const std::filesystem::path& path, const MaskLayout& layout, const ImageGeometry& image) {
    if (!image.uneven_slices_mm.empty()) {
        refuse_output(path, "the slices of the image are not evenly spaced (" + image.uneven_words() +
                                "), and a mask holds even ones only");
    }
    std::uint64_t bytes = layout.voxel_bytes * layout.layers;
    for (const std::uint64_t side : image.size) {
        if (layout.form == MaskForm::nifti && side > largest_nifti_side) {
            refuse_output(path,
                          std::to_string(side) + " voxels along a side, and NIfTI-1 holds at most 32,767; NRRD holds more");
        }
        if (side == 0 || side > largest_image_side || bytes > largest_mask_bytes / side) {
            refuse_output(path, "a mask of " + std::to_string(image.size[0]) + " x " + std::to_string(image.size[1]) +
                                    " x " + std::to_string(image.size[2]) + " voxels is larger than 2^38 bytes, or empty");
        }
        bytes *= side;
    }
}

// --- the voxels

/// Compresses `data`, of voxels of so many layers, to a piece of a gzip member; `last`: which it ends. Throws
/// std::bad_alloc.
std::vector<unsigned char> gzip_piece(std::span<const unsigned char> data, std::size_t layers, bool last) {
    z_stream stream{};
    constexpr int raw_window = -15;
    // Runs are what a mask consists of: matches at a distance cost ten times as much for a few per cent. Where layers lie
    // side by side, what repeats is as far away as they are many.
    const bool runs = layers == 1;
    if (::deflateInit2(&stream, runs ? 6 : 1, Z_DEFLATED, raw_window, 8, runs ? Z_RLE : Z_DEFAULT_STRATEGY) != Z_OK) {
        throw std::bad_alloc();
    }
    const std::unique_ptr<z_stream, int (*)(z_streamp)> ended(&stream, &::deflateEnd);
    std::vector<unsigned char> piece;
    std::array<unsigned char, 1 << 14> room{};
    constexpr std::size_t most_bytes = std::size_t{1} << 30;  // zlib takes at most 4 GB at a time
    do {
        const std::span<const unsigned char> next = data.first(std::min(most_bytes, data.size()));
        data = data.subspan(next.size());
        stream.next_in =
            const_cast<unsigned char*>(next.data());  // NOLINT(cppcoreguidelines-pro-type-const-cast): zlib's type
        stream.avail_in = static_cast<uInt>(next.size());
        const int flush = !data.empty() ? Z_NO_FLUSH : last ? Z_FINISH : Z_SYNC_FLUSH;
        do {  // until zlib leaves room: it has then taken all, and given all that the flush asks for
            stream.next_out = room.data();
            stream.avail_out = static_cast<uInt>(room.size());
            (void)::deflate(&stream, flush);
            piece.insert(piece.end(), room.data(), stream.next_out);
        } while (stream.avail_out == 0);
    } while (!data.empty());
    return piece;
}

/// A block of slices has about so much: enough for a piece of gzip.
constexpr std::size_t block_bytes = std::size_t{1} << 20;
constexpr std::size_t blocks_a_thread = 2;

/// Some slices, and their bytes as they are written where they are compressed. Memory of earlier blocks serves again: fresh
/// memory would take longer than drawing.
struct Block {
    std::vector<unsigned char> raw;
    std::vector<unsigned char> compressed;
    unsigned long crc = 0;  ///< of `raw`
    MaskCounts counts{0};
};

/// Writes blocks of slices, in their order, each made on any thread.
MaskCounts write_slices(const LayeredRaster& raster, std::span<const MaskPart> parts, const ImageGeometry& image,
                        const MaskLayout& layout, const std::string& header, OutputFile& file, const Parallel& parallel) {
    // The header of compressed NIfTI is within the gzip member, that of NRRD before it.
    const bool is_within = layout.compressed && layout.form == MaskForm::nifti;
    file.append(is_within ? std::string_view() : header);
    // Begin and end of a gzip member, without a time.
    file.append(layout.compressed ? std::string_view("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10) : std::string_view());
    const std::uint64_t slices_a_block = std::max<std::uint64_t>(1, block_bytes / raster.slice_bytes());
    const std::uint64_t blocks = (image.size[2] + slices_a_block - 1) / slices_a_block;
    std::vector<LayeredRaster::Scratch> scratch(static_cast<std::size_t>(parallel.threads()));
    std::vector<Block> made(blocks_a_thread * scratch.size());
    MaskCounts total(parts.size());
    unsigned long crc = 0;
    std::uint64_t length = 0;
    for (std::uint64_t first = 0; first < blocks && !file.failed(); first += made.size()) {
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(made.size(), blocks - first));
        parallel.run(count, [&](std::size_t i, int worker) {
            const std::uint64_t begin = (first + i) * slices_a_block;
            const std::uint64_t end = std::min(image.size[2], begin + slices_a_block);
            const std::string_view head = is_within && begin == 0 ? header : std::string_view();
            Block& block = made[i];
            block.counts = MaskCounts(parts.size());
            block.raw.resize(head.size() + (end - begin) * raster.slice_bytes());
            unsigned char* to = std::copy(head.begin(), head.end(), block.raw.data());
            for (std::uint64_t slice = begin; slice < end; ++slice, to += raster.slice_bytes()) {
                raster.draw(slice, to, scratch[static_cast<std::size_t>(worker)], block.counts);
            }
            if (layout.compressed) {
                block.compressed = gzip_piece(block.raw, layout.layers, end == image.size[2]);
                block.crc = ::crc32_z(0, block.raw.data(), block.raw.size());
            }
        });
        for (const Block& block : std::span(made).first(count)) {
            const std::vector<unsigned char>& bytes = layout.compressed ? block.compressed : block.raw;
            file.append({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
            crc = ::crc32_combine(crc, block.crc, static_cast<z_off_t>(block.raw.size()));
            length += block.raw.size();
            total.add(block.counts);
        }
    }
    std::string gzip_end(layout.compressed ? 8 : 0, '\0');
    if (layout.compressed) {
        put_at(gzip_end, 0, static_cast<std::uint32_t>(crc));
        put_at(gzip_end, 4, static_cast<std::uint32_t>(length));
    }
    file.append(gzip_end);
    return total;
}

/// NAME.labels.csv beside NAME.nii.gz: label, name, voxels.
Status write_label_table(std::span<const MaskPart> parts, const MaskSummary& summary, std::string_view name) {
    std::string rows = "label,name,voxels\n";
    for (std::size_t i = 0; i < parts.size(); ++i) {
        rows += std::to_string(i + 1) + "," + csv_text(text_of_name(parts[i].name)) + "," +
                std::to_string(summary.voxels[i]) + "\n";
    }
    return write_text_file(path_of(std::string(name) + ".labels.csv"), rows);
}

}  // namespace

MaskLayout layout_of(const std::filesystem::path& path, std::span<const MaskPart> parts, bool shares) {
    static constexpr std::array<MaskLayout, 5> layouts = {{{".seg.nrrd", MaskForm::segmentation, true},
                                                           {".nrrd", MaskForm::nrrd, true},
                                                           {".mha", MaskForm::meta, false},
                                                           {".nii.gz", MaskForm::nifti, true},
                                                           {".nii", MaskForm::nifti, false}}};
    const std::string name = lower_case(path.filename().string());
    const auto* const found = std::find_if(layouts.begin(), layouts.end(),
                                           [&](const MaskLayout& layout) { return name.ends_with(layout.name_end); });
    if (found == layouts.end()) {
        refuse_output(path, "a mask's name ends in .nii, .nii.gz, .nrrd, .seg.nrrd or .mha");
    }
    if (parts.empty() || parts.size() > (shares ? 1 : most_mask_labels)) {
        refuse_output(path, std::to_string(parts.size()) + " meshes in a mask that holds 1 to " +
                                std::to_string(shares ? 1 : most_mask_labels));
    }
    MaskLayout layout = *found;
    layout.shares = shares;
    layout.voxel_bytes = mask_voxel_bytes(parts.size());
    return layout;
}

Result<MaskSummary> write_mask(std::span<const MaskPart> parts, const ImageGeometry& image,
                               const std::filesystem::path& path, const MaskOptions& options,
                               const Context& context) noexcept {
    return guarded(context, [&]() -> Result<MaskSummary> {
        MaskLayout layout = layout_of(path, parts, options.coverage || options.subslices > 1);
        require_mask_fits(path, layout, image);
        require_cut_for(parts, image, options);
        const Parallel parallel(context);
        std::vector<std::size_t> layers(parts.size(), 0);
        if (layout.form == MaskForm::segmentation && parts.size() > 1) {
            layers = layers_of(parts, SliceRaster(parts, image, options, layout), image.size[2], parallel);
            layout.layers = 1 + *std::max_element(layers.begin(), layers.end());
            require_mask_fits(path, layout, image);
        }
        OutputFile file = require(OutputFile::create(path));
        const std::string header = layout.form == MaskForm::nifti  ? nifti_header(layout, parts.size(), image)
                                   : layout.form == MaskForm::meta ? meta_header(layout, image)
                                                                   : nrrd_header(layout, parts, layers, image);
        const LayeredRaster raster(parts, layers, image, options, layout);
        const MaskCounts counts = write_slices(raster, parts, image, layout, header, file, parallel);
        const MaskSummary summary = summary_of(counts, parts, parallel.within(context));
        require(file.commit());
        if (parts.size() > 1 && layout.form != MaskForm::segmentation) {
            const std::string name = path_text(path);
            require(write_label_table(parts, summary, name.substr(0, name.size() - layout.name_end.size())));
        }
        return summary;
    });
}

}  // namespace lamella
