// Layers of 3D Slicer's segmentations: parts that share a voxel lie in different ones.
#pragma once

#include <algorithm>
#include <compare>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "medical/mask/slice_raster.hpp"

namespace lamella {

/// The layer of each part: the first where it shares no voxel with an earlier one.
inline std::vector<std::size_t> layers_of(std::span<const MaskPart> parts, const SliceRaster& raster, std::uint64_t slices,
                                          const Parallel& parallel) {
    struct Span {
        std::size_t row;
        std::size_t begin;
        std::size_t end;
        std::size_t part;

        auto operator<=>(const Span&) const = default;
    };
    struct Found {
        SliceRaster::Scratch scratch;
        std::vector<Span> spans;
        std::set<std::pair<std::size_t, std::size_t>> pairs;  ///< that share a voxel, the later part first
    };
    std::vector<Found> found(static_cast<std::size_t>(parallel.threads()));
    parallel.run(slices, [&](std::size_t slice, int worker) {
        auto& [scratch, spans, pairs] = found[static_cast<std::size_t>(worker)];
        spans.clear();
        for (std::size_t part = 0; part < parts.size(); ++part) {
            raster.for_each_span(slice, part, scratch,
                                 [&spans = spans, part](std::size_t row, std::size_t begin, std::size_t end) {
                                     spans.push_back({row, begin, end, part});
                                 });
        }
        std::sort(spans.begin(), spans.end());
        for (auto a = spans.begin(); a != spans.end(); ++a) {
            for (auto b = a + 1; b != spans.end() && b->row == a->row && b->begin < a->end; ++b) {
                pairs.emplace(std::max(a->part, b->part), std::min(a->part, b->part));
            }
        }
    });
    for (std::size_t i = 1; i < found.size(); ++i) {
        found[0].pairs.merge(found[i].pairs);
    }
    std::vector<std::size_t> layers(parts.size());
    auto pair = found[0].pairs.begin();
    for (std::size_t part = 0; part < parts.size(); ++part) {
        std::set<std::size_t> taken;
        for (; pair != found[0].pairs.end() && pair->first == part; ++pair) {
            taken.insert(layers[pair->second]);
        }
        for (; taken.contains(layers[part]); ++layers[part]) {
        }
    }
    return layers;
}

/// Draws several layers, the voxels of all of them side by side.
class LayeredRaster {
public:
    /// `layers`: of each part; none is empty. What it is made of must outlive it.
    LayeredRaster(std::span<const MaskPart> parts, std::span<const std::size_t> layers, const ImageGeometry& image,
                  const MaskOptions& options, const MaskLayout& layout)
        : voxel_bytes_(layout.voxel_bytes), layers_(1 + *std::max_element(layers.begin(), layers.end())) {
        for (std::size_t i = 0; i < parts.size(); ++i) {
            layers_[layers[i]].parts.push_back(parts[i]);
            layers_[layers[i]].index.push_back(i);
        }
        for (const PartsOfLayer& layer : layers_) {
            rasters_.emplace_back(layer.parts, image, options, layout);
        }
    }

    struct Scratch : SliceRaster::Scratch {
        std::vector<unsigned char> layer;
    };

    std::size_t slice_bytes() const noexcept { return rasters_.size() * rasters_[0].slice_bytes(); }

    /// As SliceRaster::draw(). A part's label is its number within its layer.
    void draw(std::uint64_t slice, unsigned char* to, Scratch& scratch, MaskCounts& counts) const {
        if (rasters_.size() == 1) {
            rasters_[0].draw(slice, to, scratch, counts);
            return;
        }
        scratch.layer.resize(rasters_[0].slice_bytes());
        for (std::size_t i = 0; i < rasters_.size(); ++i) {
            MaskCounts own(layers_[i].parts.size());
            rasters_[i].draw(slice, scratch.layer.data(), scratch, own);
            for (std::size_t byte = 0; byte < voxel_bytes_; ++byte) {
                unsigned char* next = to + i * voxel_bytes_ + byte;
                for (std::size_t at = byte; at < scratch.layer.size(); at += voxel_bytes_) {
                    *next = scratch.layer[at];
                    next += voxel_bytes_ * rasters_.size();
                }
            }
            for (std::size_t part = 0; part < own.parts.size(); ++part) {
                counts.parts[layers_[i].index[part]].add(own.parts[part]);
            }
        }
    }

private:
    struct PartsOfLayer {
        std::vector<MaskPart> parts;
        std::vector<std::size_t> index;  ///< of each part among all
    };

    std::size_t voxel_bytes_;
    std::vector<PartsOfLayer> layers_;
    std::vector<SliceRaster> rasters_;
};

}  // namespace lamella
