// Slicing in ranges, held against slicing in memory.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "input/ply_writer.hpp"
#include "input/read.hpp"
#include "lamella/io.hpp"

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

using ply_test::PlyVariant;

inline constexpr std::string_view little = "binary_little_endian";
inline constexpr std::string_view big = "binary_big_endian";

inline std::string ply_of(const shapes::Soup& soup, const PlyVariant& form) {
    return ply_test::ply(form, shapes::indexed(soup));
}

inline std::string stl_of(const shapes::Soup& soup) {
    const std::vector<float> numbers = shapes::floats(soup);
    std::vector<Facet> facets(numbers.size() / 9);
    std::memcpy(facets.data(), numbers.data(), numbers.size() * sizeof(float));
    return binary_stl(facets);
}

inline std::filesystem::path made(models::Shape shape, models::Order order, std::uint64_t triangles) {
    std::filesystem::path path = dir / "mesh.stl";
    REQUIRE(models::write_stl({.shape = shape, .triangles = triangles, .order = order}, path).ok());
    return path;
}

inline auto counts_of(const SliceInfo& info) {
    return std::tuple(info.triangles, info.degenerate, info.crossed, info.layers, info.segments, info.contours, info.points,
                      info.stitches, info.holes, info.open_contours, info.flat_contours, info.overruled_contours,
                      info.would_close_contours, info.emptied_layers, info.cancelled_layers, info.first_layer,
                      info.planned_layers, info.grid_doublings);
}

struct Ranges {
    SliceResult result;
    MeshStream::Spent spent;
};

inline Ranges in_ranges(const std::filesystem::path& path, const StreamOptions& stream, const SliceOptions& options,
                        const Context& context = {}, const Tuning& tuning = {}) {
    const MeshStream file = value_of(open_mesh(path, stream));
    SliceResult result = sliced(file, options, context, tuning);
    return {std::move(result), file.spent()};
}

/// The message of opening or slicing the file; empty where it is sliced.
inline std::string refusal_of(const std::filesystem::path& path, const StreamOptions& stream = {},
                              const SliceOptions& options = {}, const Context& context = {}) {
    const Result<MeshStream> file = open_mesh(path, stream);
    if (!file) {
        return error_of(file).message;
    }
    Slicer slicer;
    const auto take = [](const LayerView&) noexcept {};
    const Result<SliceInfo> sliced = slicer.slice_to(LayerSink{.take = take}, *file, options, context);
    return sliced ? "" : error_of(sliced).message;
}

inline void require_same(const SliceResult& whole, const Ranges& ranges) {
    const SliceResult& result = ranges.result;
    REQUIRE(result.hash() == whole.hash());
    CHECK((counts_of(result.info) == counts_of(whole.info)));
    CHECK(result.info.options == whole.info.options);
    CHECK(result.info.box == whole.info.box);
    CHECK(result.info.grid_mm == whole.info.grid_mm);
    CHECK(result.info.layer_of == whole.info.layer_of);
    CHECK(std::equal(result.layers.begin(), result.layers.end(), whole.layers.begin(), [](const auto& a, const auto& b) {
        return a.bottom_mm == b.bottom_mm && a.plane_mm == b.plane_mm && a.top_mm == b.top_mm && a.segments == b.segments;
    }));
    CHECK(std::equal(result.stitches.begin(), result.stitches.end(), whole.stitches.begin(), whole.stitches.end(),
                     [](const auto& a, const auto& b) { return a.layer == b.layer && a.from == b.from && a.to == b.to; }));
}

/// The budget that the refusal of a byte names, or that the vertices alone need.
inline std::uint64_t least_budget(const std::filesystem::path& path, const SliceOptions& options, const Context& context,
                                  const Tuning& tuning = {}) {
    StreamOptions stream{.memory_bytes = 1};
    for (bool vertices = true; vertices;) {
        const MeshStream file = value_of(open_mesh(path, stream));
        Slicer slicer;
        SliceResult result;
        const Result<SliceInfo> refused = slice_tuned(slicer, result, file, options, tuning, context);
        if (!refused) {
            REQUIRE(refused.error().code == ErrorCode::out_of_memory);
        }
        const std::string message = refused ? "" : refused.error().message;
        vertices = message.find("stay in memory") != std::string::npos;
        stream.memory_bytes = refused ? stream.memory_bytes : std::stoull(message.substr(message.rfind(' ') + 1));
    }
    return stream.memory_bytes;
}

/// At the whole of the need, a half, a tenth and a fiftieth, or as near as the widest layer and the tables allow, on one
/// thread and on three.
inline void require_same_at_all_budgets(const std::filesystem::path& path, const SliceOptions& options,
                                        const Tuning& tuning = {}) {
    const MeshFile mesh = value_of(read_mesh(path));
    const SliceResult whole = sliced(mesh, options, {}, tuning);
    const std::uint64_t need = 50 * mesh.triangle_count + 48 * whole.info.crossed;  // the file and the crossed triangles
    for (const int threads : thread_counts) {
        for (const std::uint64_t part : parts_of_need) {
            const Context context{.threads = threads};
            const std::uint64_t budget = std::max(need / part, least_budget(path, options, context, tuning));
            INFO("1/" << part << " of the need, " << budget << " bytes, " << threads << " threads");
            require_same(whole, in_ranges(path, {.memory_bytes = budget}, options, context, tuning));
        }
    }
}

}  // namespace lamella::input_test
