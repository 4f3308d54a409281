// Slices of the golden cases, and the hash of everything that they hold. Times, threads,
// bands and paths are left out: they are not part of what is promised.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "golden/golden_file.hpp"
#include "golden/inputs.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "slicing/tuning.hpp"

namespace golden {

using Options = lamella::SliceOptions;
using Rule = lamella::FillRule;

// The same options but for one thing.

inline Options above(Options options) {
    options.planes.side = lamella::PlaneSide::above;
    return options;
}

inline Options filled(Rule rule, Options options) {
    options.region.fill_rule = rule;
    return options;
}

inline Options stitched(double reach_mm, Options options) {
    options.stitch_mm = reach_mm;
    return options;
}

inline Options on_grid(double grid_mm, Options options) {
    options.frame.grid_mm = grid_mm;
    return options;
}

inline Options turned(double x, double y, double z, Options options) {
    options.frame.transform = lamella::Transform::from_normal(x, y, z);
    return options;
}

/// How coordinates lie in memory.
enum class Form : std::uint8_t { f64_soup, f32_soup, f64_indexed, f32_indexed, f32_strided };

/// A mesh in memory of its own.
class HeldMesh {
public:
    explicit HeldMesh(const Soup& soup, Form form = Form::f64_soup);
    lamella::MeshView view() const;

private:
    Form form_;
    Soup f64_;
    std::vector<float> f32_;
    std::vector<std::uint32_t> indices_;
    std::string strided_;
};

/// Every field of contours, and points.
Hash& add_contours(Hash& hash, std::span<const lamella::Contour> contours, std::span<const lamella::Point> points);

/// Adds "NAME" (planes, contours and points) and "NAME, numbers" (heights, areas, stitches, counts, box), which must be
/// the same on 1 and more threads, in bands of 1, 3 and the default number of planes, and in both forms of construction.
/// Returns the most bands that there were by default.
std::uint64_t add_slices(Hashes& hashes, const std::string& name, const lamella::MeshView& mesh, const Options& options,
                         lamella::Tuning tuning = {});

}  // namespace golden
