#include "base/parallel.hpp"
#include "lamella/audit.hpp"
#include "medical/geometry/common.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella {

MaskSummary summary_of(const MaskCounts& counts, std::span<const MaskPart> parts, const Context& context) {
    constexpr AuditOptions only_open{.volume = false, .ledger = false, .crossings = false};
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    MaskSummary summary;
    summary.overlapped_voxels = counts.overlapped;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto& [voxels, area, inside, length] = counts.parts[i];
        const OpenLayers open = *require(audit(*parts[i].result, MeshView{}, only_open, context)).open;
        const bool all_open = open.layers > 0 && open.layers == open.crossed;
        const bool is_cut_off = area - inside > 1e-9 * area;  // less is rounding
        summary.voxels.push_back(voxels);
        summary.open.push_back(open);
        summary.cut_off_share.push_back(all_open ? unknown : is_cut_off ? (area - inside) / area : 0);
        summary.mean_wall_mm.push_back(length > 0 ? area / length : unknown);
    }
    return summary;
}

void require_cut_for(std::span<const MaskPart> parts, const ImageGeometry& image, const MaskOptions& options,
                     std::optional<std::uint64_t> slices) {
    if (options.subslices < 1) {
        throw Refused{
            {ErrorCode::invalid_argument, "a slice has at least one plane, not " + std::to_string(options.subslices)}};
    }
    for (const MaskPart& part : parts) {
        const auto planes = static_cast<std::uint64_t>(options.subslices);
        require_cut(part.result, part.name, image.size[2] * planes, options.first_slice * planes,
                    slices.value_or(image.size[2]) * planes);
    }
}

Result<MaskSummary> draw_mask(std::span<const MaskPart> parts, const ImageGeometry& image, std::span<unsigned char> voxels,
                              const MaskOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<MaskSummary> {
        MaskLayout layout;
        layout.shares = options.coverage || options.subslices > 1;
        layout.voxel_bytes = mask_voxel_bytes(parts.size());
        const auto refuse_if = [](bool wrong, const std::string& what) {
            if (wrong) {
                throw Refused{{ErrorCode::invalid_argument, what}};
            }
        };
        refuse_if(parts.empty() || parts.size() > (layout.shares ? 1 : most_mask_labels),
                  "a mask is of 1 to 65,535 meshes, and one of shares of one");
        refuse_if(!image.uneven_slices_mm.empty(),
                  "the slices of the image are not evenly spaced (" + image.uneven_words() + "), and a mask's are");
        const SliceRaster raster(parts, image, options, layout);
        const std::uint64_t slices = voxels.size() / std::max<std::size_t>(raster.slice_bytes(), 1);
        refuse_if(slices == 0 || voxels.size() % raster.slice_bytes() != 0 || options.first_slice > image.size[2] ||
                      slices > image.size[2] - options.first_slice,
                  "the voxels do not have the size of slices of the image");
        require_cut_for(parts, image, options, slices);
        const Parallel parallel(context);
        std::vector<SliceRaster::Scratch> scratch(static_cast<std::size_t>(parallel.threads()));
        std::vector<MaskCounts> counts(slices, MaskCounts(parts.size()));  // added in order, as sums are rounded
        parallel.begin_stage(1);
        parallel.run(slices, [&](std::size_t i, int worker) {
            raster.draw(options.first_slice + i, voxels.data() + i * raster.slice_bytes(),
                        scratch[static_cast<std::size_t>(worker)], counts[i]);
        });
        parallel.finish();
        for (std::size_t slice = 1; slice < counts.size(); ++slice) {
            counts[0].add(counts[slice]);
        }
        return summary_of(counts[0], parts, parallel.within(context));
    });
}

}  // namespace lamella
