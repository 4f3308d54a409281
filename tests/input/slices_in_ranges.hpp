// Slicing in ranges, held against slicing in memory.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"

namespace lamella::input_test {

#ifdef LAMELLA_TESTS_SANITIZED
inline constexpr int thread_counts[] = {3};
inline constexpr std::uint64_t parts_of_need[] = {2, 50};
inline constexpr double budget_heights_mm[] = {1.0};
inline constexpr std::uint64_t budget_triangles = 80'000;
#else
inline constexpr int thread_counts[] = {1, 3};
inline constexpr std::uint64_t parts_of_need[] = {1, 2, 10, 50};
inline constexpr double budget_heights_mm[] = {0.05, 1.0};
inline constexpr std::uint64_t budget_triangles = 400'000;
#endif

/// What a budget is to be compared with: the file and the crossed triangles.
inline std::uint64_t need_of(const MeshFile& mesh, const SliceResult& result) {
    return 50 * mesh.triangle_count + 48 * result.summary.crossed;
}

inline std::vector<std::uint64_t> counts_of(const lamella::SliceSummary& summary) {
    return {summary.triangles,
            summary.degenerate,
            summary.crossed,
            summary.segments,
            summary.holes,
            summary.open_contours,
            summary.flat_contours,
            summary.overruled_contours,
            summary.near_contours,
            summary.emptied_layers,
            static_cast<std::uint64_t>(summary.unit_doublings)};
}

inline void require_same(const SliceResult& whole, const CollectedFileSlice& ranges) {
    const SliceResult& result = ranges.result;
    REQUIRE(ranges.file.hash == hash_result(whole));
    REQUIRE(hash_result(result) == hash_result(whole));
    CHECK(counts_of(result.summary) == counts_of(whole.summary));
    CHECK(std::equal(result.summary.min_mm, result.summary.min_mm + 3, whole.summary.min_mm));
    CHECK(std::equal(result.summary.max_mm, result.summary.max_mm + 3, whole.summary.max_mm));
    CHECK(result.unit_mm == whole.unit_mm);
    CHECK(result.first_layer == whole.first_layer);
    CHECK(result.all_layers == whole.all_layers);
    CHECK(result.frame == whole.frame);
    CHECK(std::equal(result.layer_of.begin(), result.layer_of.end(), whole.layer_of.begin(), whole.layer_of.end()));
    REQUIRE(result.closed_gaps.size() == whole.closed_gaps.size());
    CHECK(std::equal(result.layers.begin(), result.layers.end(), whole.layers.begin(), [](const auto& a, const auto& b) {
        return a.bottom_mm == b.bottom_mm && a.plane_mm == b.plane_mm && a.top_mm == b.top_mm && a.segments == b.segments;
    }));
    CHECK(std::equal(result.closed_gaps.begin(), result.closed_gaps.end(), whole.closed_gaps.begin(),
                     [](const auto& a, const auto& b) { return a.layer == b.layer && a.from == b.from && a.to == b.to; }));
    CHECK(lamella::validate(result));
}

inline CollectedFileSlice in_ranges(const std::filesystem::path& path, FileSliceOptions options) {
    options.hash = true;
    lamella::Result<CollectedFileSlice> ranges = lamella::slice_file(path, options);
    INFO((ranges ? std::string() : ranges.error().message));
    REQUIRE(ranges.ok());
    return std::move(ranges).value();
}

/// What the refusal of a byte names, or that of what vertices alone need.
inline std::uint64_t least_budget(const std::filesystem::path& path, FileSliceOptions options) {
    options.memory_bytes = 1;
    for (bool vertices = true; vertices;) {
        const auto refused = lamella::slice_file(path, options);
        if (!refused) {
            REQUIRE(refused.error().code == lamella::ErrorCode::out_of_memory);
        }
        const std::string message = refused ? "" : refused.error().message;
        vertices = message.find("stay in memory") != std::string::npos;
        options.memory_bytes = refused ? options.memory_bytes : std::stoull(message.substr(message.rfind(' ') + 1));
    }
    return options.memory_bytes;
}

/// At the whole of the need, a half, a tenth and a fiftieth, or as near as the widest layer and the tables allow, on one
/// thread and on three.
inline void require_same_at_all_budgets(const std::filesystem::path& path, const SliceOptions& slicing) {
    const auto mesh = lamella::read_mesh(path);
    REQUIRE(mesh);
    const auto whole = lamella::slice(*mesh, slicing);
    INFO((whole ? std::string() : whole.error().message));
    REQUIRE(whole);
    const std::uint64_t need = need_of(*mesh, *whole);
    for (const int threads : thread_counts) {
        for (const std::uint64_t part : parts_of_need) {
            FileSliceOptions options;
            options.slice = slicing;
            options.slice.control.threads = threads;
            options.memory_bytes = std::max(need / part, least_budget(path, options));
            INFO("1/" << part << " of the need, " << options.memory_bytes << " bytes, " << threads << " threads");
            require_same(*whole, in_ranges(path, options));
        }
    }
}

inline SliceOptions layers_of(double height_mm) {
    SliceOptions options;
    options.plan.spacing = lamella::UniformLayers{.layer_height_mm = height_mm};
    return options;
}

}  // namespace lamella::input_test
