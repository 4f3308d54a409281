#include "lamella/medical/mask.hpp"

#include <array>
#include <memory>

#include <zlib.h>

#include "base/little_endian.hpp"
#include "base/parallel.hpp"
#include "base/system/file.hpp"
#include "base/words.hpp"
#include "io/text/text.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/text_file.hpp"
#include "medical/geometry/common.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella {

namespace {

// --- the header: everything before the voxels

constexpr std::uint64_t largest_nifti_side = 32767;
constexpr std::uint64_t largest_mask_bytes = std::uint64_t{1} << 38;

std::string vector_text(const Direction& at) {
    return "(" + exact_text(at[0]) + "," + exact_text(at[1]) + "," + exact_text(at[2]) + ")";
}

/// NIfTI's numbers, and gzip's, are written little-endian.
template <class T>
void put(std::string& header, std::size_t at, T value) {
    std::memcpy(header.data() + at, &value, sizeof value);
}

/// The quaternion (b, c, d) of the rotation whose columns are `axes`, right-handed.
std::array<double, 3> quaternion(const std::array<Direction, 3>& axes) {
    const auto& [x, y, z] = axes;
    // Four times the products of its components a, b, c and d.
    const std::array<std::array<double, 4>, 4> products = {{
        {1 + x[0] + y[1] + z[2], y[2] - z[1], z[0] - x[2], x[1] - y[0]},
        {y[2] - z[1], 1 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2]},
        {z[0] - x[2], y[0] + x[1], 1 + y[1] - x[0] - z[2], z[1] + y[2]},
        {x[1] - y[0], z[0] + x[2], z[1] + y[2], 1 + z[2] - x[0] - y[1]},
    }};
    std::size_t most = 0;
    for (std::size_t i = 1; i < 4; ++i) {
        most = products[i][i] > products[most][most] ? i : most;
    }
    const std::array<double, 4>& row = products[most];
    const double scale = (row[0] < 0 ? -0.5 : 0.5) / std::sqrt(row[most]);
    return {scale * row[1], scale * row[2], scale * row[3]};
}

std::string nifti_header(const MaskLayout& layout, std::size_t labels, const ImageGeometry& image) {
    std::string header(352, '\0');
    put<std::int32_t>(header, 0, 348);
    header[38] = 'r';
    put<std::int16_t>(header, 40, 3);  // dimensions, then the size of each of seven
    for (std::size_t i = 0; i < 7; ++i) {
        put(header, 42 + 2 * i, static_cast<std::int16_t>(i < 3 ? image.size[i] : 1));
    }
    put<std::int16_t>(header, 70, layout.voxel_bytes == 1 ? 2 : 512);  // uint8, uint16
    put<std::int16_t>(header, 72, static_cast<std::int16_t>(8 * layout.voxel_bytes));
    std::array<Direction, 3> axes = image.axes;  // in RAS, as what follows
    std::array<Direction, 3> steps = image.steps_mm();
    for (Direction* const direction : {&axes[0], &axes[1], &axes[2], &steps[0], &steps[1], &steps[2]}) {
        *direction = {-(*direction)[0], -(*direction)[1], (*direction)[2]};
    }
    const bool left_handed = dot(cross(axes[0], axes[1]), axes[2]) < 0;
    put(header, 76, left_handed ? -1.0F : 1.0F);
    for (std::size_t i = 0; i < 3; ++i) {
        put(header, 80 + 4 * i, static_cast<float>(i == 2 && image.is_sheared() ? length(steps[i]) : image.spacing_mm[i]));
    }
    put(header, 108, 352.0F);
    put(header, 112, layout.shares ? 1.0F / 255.0F : 1.0F);
    header[123] = 2;  // mm
    put(header, 124, layout.shares ? 1.0F : static_cast<float>(labels));
    std::memcpy(header.data() + 148, "lamella", 7);
    put<std::int16_t>(header, 252, image.is_sheared() ? 0 : 1);  // a qform cannot say it
    put<std::int16_t>(header, 254, 1);
    const std::array<double, 3> origin = {-image.origin_mm[0], -image.origin_mm[1], image.origin_mm[2]};
    const std::array<double, 3> turn = quaternion({axes[0], axes[1], left_handed ? scaled(axes[2], -1) : axes[2]});
    for (std::size_t i = 0; i < 3; ++i) {
        put(header, 256 + 4 * i, static_cast<float>(turn[i]));
        put(header, 268 + 4 * i, static_cast<float>(origin[i]));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            put(header, 280 + 16 * i + 4 * axis, static_cast<float>(steps[axis][i]));
        }
        put(header, 292 + 16 * i, static_cast<float>(origin[i]));
    }
    std::memcpy(header.data() + 344, "n+1", 3);
    return header;
}

std::string segments_of(std::span<const MaskPart> parts, const ImageGeometry& image) {
    static constexpr std::array<const char*, 6> colours = {"0.9 0.3 0.2", "0 0.45 0.7",    "0 0.62 0.45",
                                                           "0.9 0.62 0",  "0.8 0.47 0.65", "0.34 0.7 0.91"};
    std::string text =
        "Segmentation_ContainedRepresentationNames:=Binary labelmap|\n"
        "Segmentation_MasterRepresentation:=Binary labelmap\nSegmentation_ReferenceImageExtentOffset:=0 0 0\n";
    std::string extent;
    for (const std::uint64_t side : image.size) {
        extent += (extent.empty() ? "0 " : " 0 ") + std::to_string(side - 1);
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const std::string segment = "Segment" + std::to_string(i) + "_";
        const std::string label = std::to_string(i + 1);
        std::string name = text_of_name(parts[i].name);
        std::replace_if(
            name.begin(), name.end(), [](unsigned char c) { return c < ' '; }, ' ');  // what would end a line
        for (const auto& [key, value] : {std::pair<const char*, std::string>{"ID", "Segment_" + label},
                                         {"Name", name},
                                         {"NameAutoGenerated", "0"},
                                         {"LabelValue", label},
                                         {"Layer", "0"},
                                         {"Color", colours[i % colours.size()]},
                                         {"ColorAutoGenerated", "1"},
                                         {"Extent", extent}}) {
            text.append(segment).append(key).append(":=").append(value).append("\n");
        }
    }
    return text;
}

std::string nrrd_header(const MaskLayout& layout, std::span<const MaskPart> parts, const ImageGeometry& image) {
    std::string sizes;
    std::string directions;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        sizes += " " + std::to_string(image.size[axis]);
        directions += " " + vector_text(image.steps_mm()[axis]);
    }
    std::string text =
        "NRRD0004\n# Written by lamella.\ntype: " +
        std::string(layout.voxel_bytes == 1 ? "unsigned char" : "unsigned short") +
        "\ndimension: 3\nspace: left-posterior-superior\nsizes:" + sizes + "\nspace directions:" + directions +
        "\nkinds: domain domain domain\n" + (layout.voxel_bytes == 1 ? "" : "endian: little\n") +
        "encoding: " + (layout.compressed ? "gzip" : "raw") + "\nspace origin: " + vector_text(image.origin_mm) + "\n";
    if (layout.shares) {
        text += "lamella_share:=255 stands for 1\n";
    }
    return text + (layout.form == MaskForm::segmentation ? segments_of(parts, image) : "") + "\n";
}

/// Throws Refused where the format, or any, does not hold a mask of that size.
void require_mask_fits(const std::filesystem::path& path, const MaskLayout& layout, const ImageGeometry& image) {
    if (!image.uneven_slices_mm.empty()) {
        refuse_output(path, "the slices of the image are not evenly spaced (" + image.uneven_words() +
                                "), and a mask holds even ones only");
    }
    std::uint64_t bytes = layout.voxel_bytes;
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

/// Compresses `data` to a piece of a gzip member; `last`: which it ends. Throws std::bad_alloc.
std::vector<unsigned char> gzip_piece(std::span<const unsigned char> data, bool last) {
    z_stream stream{};
    constexpr int raw_window = -15;
    // Runs are what a mask consists of: matches at a distance cost ten times as much for a few per cent.
    if (::deflateInit2(&stream, 6, Z_DEFLATED, raw_window, 8, Z_RLE) != Z_OK) {
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
MaskCounts write_slices(const SliceRaster& raster, std::span<const MaskPart> parts, const ImageGeometry& image,
                        const MaskLayout& layout, OutputFile& file, const Parallel& parallel) {
    const std::string header =
        layout.form == MaskForm::nifti ? nifti_header(layout, parts.size(), image) : nrrd_header(layout, parts, image);
    // The header of compressed NIfTI is within the gzip member, that of NRRD before it.
    const bool is_within = layout.compressed && layout.form == MaskForm::nifti;
    file.append(is_within ? std::string_view() : header);
    // Begin and end of a gzip member, without a time.
    file.append(layout.compressed ? std::string_view("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10) : std::string_view());
    const std::uint64_t slices_a_block = std::max<std::uint64_t>(1, block_bytes / raster.slice_bytes());
    const std::uint64_t blocks = (image.size[2] + slices_a_block - 1) / slices_a_block;
    std::vector<SliceRaster::Scratch> scratch(static_cast<std::size_t>(parallel.threads()));
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
                block.compressed = gzip_piece(block.raw, end == image.size[2]);
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
        put(gzip_end, 0, static_cast<std::uint32_t>(crc));
        put(gzip_end, 4, static_cast<std::uint32_t>(length));
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
    static constexpr std::array<MaskLayout, 4> layouts = {{{".seg.nrrd", MaskForm::segmentation, true},
                                                           {".nrrd", MaskForm::nrrd, true},
                                                           {".nii.gz", MaskForm::nifti, true},
                                                           {".nii", MaskForm::nifti, false}}};
    const std::string name = lower_case(path.filename().string());
    const auto* const found = std::find_if(layouts.begin(), layouts.end(),
                                           [&](const MaskLayout& layout) { return name.ends_with(layout.name_end); });
    if (found == layouts.end()) {
        refuse_output(path, "a mask's name ends in .nii, .nii.gz, .nrrd or .seg.nrrd");
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
        const MaskLayout layout = layout_of(path, parts, options.coverage || options.subslices > 1);
        require_mask_fits(path, layout, image);
        require_cut_for(parts, image, options);
        const SliceRaster raster(parts, image, options, layout);
        const Parallel parallel(context);
        OutputFile file = require(OutputFile::create(path));
        const MaskCounts counts = write_slices(raster, parts, image, layout, file, parallel);
        const MaskSummary summary = summary_of(counts, parts, parallel.within(context));
        require(file.commit());
        if (parts.size() > 1) {
            const std::string name = path_text(path);
            require(write_label_table(parts, summary, name.substr(0, name.size() - layout.name_end.size())));
        }
        return summary;
    });
}

}  // namespace lamella
