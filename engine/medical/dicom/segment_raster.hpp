// The voxels of a segmentation: which slices hold some of a part, and their bits.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "io/write/output_file.hpp"
#include "lamella/medical/segmentation.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella {

/// A slice of a segment.
struct SegmentFrame {
    std::size_t segment;
    std::uint64_t slice;
};

/// Draws the slices of each part by itself.
class SegmentRaster {
public:
    SegmentRaster(std::span<const MaskPart> parts, const ImageGeometry& image, const SegmentationOptions& options,
                  const Parallel& parallel)
        : parts_(parts),
          slices_(image.size[2]),
          options_{.coverage = options.coverage, .subslices = options.subslices},
          parallel_(parallel),
          drawn_(frames_a_thread * static_cast<std::size_t>(parallel.threads())),
          scratch_(static_cast<std::size_t>(parallel.threads())) {
        layout_.shares = options.coverage || options.subslices > 1;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            rasters_.emplace_back(parts.subspan(i, 1), image, options_, layout_);
        }
    }

    bool shares() const noexcept { return layout_.shares; }
    std::uint64_t frame_bits() const noexcept { return rasters_[0].slice_bytes() * (shares() ? 8 : 1); }

    /// The slices of each part that contours of it lie in, or one of a part that is nowhere.
    std::vector<SegmentFrame> frames() const {
        std::vector<SegmentFrame> frames;
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const std::size_t before = frames.size();
            for (std::size_t slice = 0; slice < slices_; ++slice) {
                if (has_contours(*parts_[i].result, slice)) {
                    frames.push_back({i, slice});
                }
            }
            if (frames.size() == before) {
                frames.push_back({i, 0});
            }
        }
        return frames;
    }

    /// Writes them one after another, the first voxel into the lowest bit, without a gap where one ends within a byte. Adds
    /// to `counts`.
    void write_pixels(std::span<const SegmentFrame> frames, OutputFile& file, MaskCounts& counts) {
        char begun = 0;  // the byte within which the last frame has ended
        for (std::size_t first = 0; first < frames.size() && !file.failed(); first += drawn_.size()) {
            const std::size_t count = std::min(drawn_.size(), frames.size() - first);
            parallel_.run(count, [&](std::size_t i, int worker) {
                const auto& [segment, slice] = frames[first + i];
                const SliceRaster& raster = rasters_[segment];
                drawn_[i].counts = MaskCounts(1);
                drawn_[i].voxels.resize(raster.slice_bytes());
                raster.draw(slice, drawn_[i].voxels.data(), scratch_[static_cast<std::size_t>(worker)], drawn_[i].counts);
                pack(drawn_[i], (first + i) * frame_bits() % 8);
            });
            for (std::size_t i = 0; i < count; ++i) {
                counts.parts[frames[first + i].segment].add(drawn_[i].counts.parts[0]);
                std::string& bits = drawn_[i].bits;
                bits[0] = static_cast<char>(bits[0] | begun);
                const bool is_whole = (first + i + 1) * frame_bits() % 8 == 0;
                begun = is_whole ? '\0' : bits.back();
                file.append(std::string_view(bits).substr(0, bits.size() - (is_whole ? 0 : 1)));
            }
        }
        const std::uint64_t bits = frames.size() * frame_bits();
        file.append({&begun, bits % 8 == 0 ? 0U : 1U});
        file.append(std::string_view("\0", (bits + 7) / 8 % 2));  // an element's length is even
    }

private:
    static constexpr std::size_t frames_a_thread = 4;

    struct Drawn {
        std::vector<unsigned char> voxels;
        std::string bits;
        MaskCounts counts{1};
    };

    bool has_contours(const SliceResult& result, std::uint64_t slice) const {
        const auto planes = static_cast<std::uint64_t>(options_.subslices);
        const auto layers = std::span(result.info.layer_of).subspan(slice * planes, planes);
        return std::any_of(layers.begin(), layers.end(),
                           [&](std::uint64_t layer) { return result.layers[layer].contour_count > 0; });
    }

    /// From bit `at` of the first byte on.
    void pack(Drawn& drawn, std::size_t at) const {
        if (shares()) {
            drawn.bits.assign(drawn.voxels.begin(), drawn.voxels.end());
            return;
        }
        drawn.bits.assign((at + drawn.voxels.size() + 7) / 8, '\0');
        for (const unsigned char voxel : drawn.voxels) {
            drawn.bits[at / 8] = static_cast<char>(static_cast<unsigned char>(drawn.bits[at / 8]) | voxel << at % 8);
            ++at;
        }
    }

    std::span<const MaskPart> parts_;
    std::size_t slices_;
    MaskOptions options_;
    MaskLayout layout_{};
    const Parallel& parallel_;
    std::vector<Drawn> drawn_;  ///< of frames that are drawn at the same time
    std::vector<SliceRaster::Scratch> scratch_;
    std::vector<SliceRaster> rasters_;  ///< of each part
};

}  // namespace lamella
