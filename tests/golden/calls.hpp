// Every call of the library that the golden cases make, and the hash of everything that the answer holds. Times, threads,
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

#include "golden/golden_file.hpp"
#include "golden/inputs.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "slicing/tuning.hpp"

namespace golden {

/// Random heights are for experiments: they have no place among the options of a slice.
struct Options : lamella::SliceOptions {
    lamella::Tuning tuning{};
};
using Rule = lamella::FillRule;
using Segments = std::vector<lamella::Segment>;

// Where to cut.
Options uniform(double layer_mm);
Options uniform_from(double first_mm, double layer_mm);  ///< counted from z = 0
Options at_heights(std::vector<double> heights_mm);
Options random_layers(double min_mm, double max_mm, std::uint64_t seed);

// The same options, but for one thing.
Options above(Options options);
Options filled(Rule rule, Options options);
Options stitched(double reach_mm, Options options);
Options on_grid(double grid_mm, Options options);
Options turned(double x, double y, double z, Options options);
/// Axes exchanged, mirrored, halved and moved: all exact.
Options mapped(Options options);

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

/// The value of a call that must succeed.
template <class T>
T answer(lamella::Result<T> result) {
    INFO((result ? std::string() : result.error().message));
    REQUIRE(result.ok());
    return std::move(result).value();
}

/// Every field of contours, and points.
Hash& add_contours(Hash& hash, std::span<const lamella::Contour> contours, std::span<const lamella::Point> points);

lamella::SliceResult sliced(const lamella::MeshView& mesh, const Options& options, const lamella::Context& context = {});

/// Adds "NAME" (planes, contours and points) and "NAME, numbers" (heights, areas, stitches, counts, box), which must be
/// the same on 1 and more threads, in bands of 1, 3 and the default number of planes, and in both forms of construction.
/// Returns the most bands that there were by default.
std::uint64_t add_slices(Group& group, const std::string& name, const lamella::MeshView& mesh, const Options& options);

/// Adds "NAME, welded" and the slices of the outcome.
void add_weld(Group& group, const std::string& name, const lamella::MeshView& mesh, double tolerance_mm);

/// Adds "NAME, ledger", "..., volume" and "..., crossings", the same on 1 and 3 threads.
void add_audit(Group& group, const std::string& name, const lamella::MeshView& mesh, const Options& options);

/// Adds "NAME, report" and "NAME, SVG".
void add_written(Group& group, const std::string& name, const lamella::MeshView& mesh, const Options& options);

/// Adds "NAME, inspected", "NAME, check" (the JSON) and "NAME, marks" (the PLY), the same on 1 and 3 threads.
void add_check(Group& group, const std::string& name, const lamella::MeshView& mesh);

/// A segment between two keys; points are the keys' numbers by some rule of the caller.
lamella::Segment segment(std::uint64_t from_key, std::uint64_t to_key, std::array<std::int32_t, 2> from,
                         std::array<std::int32_t, 2> to, std::uint32_t from_rank = 0, std::uint32_t to_rank = 0);
void add_assembled(Group& group, const std::string& name, const Segments& segments);

/// Adds "NAME": coordinates, indices, format, unit and frame of a file, the same read and mapped, on 1 and 3 threads.
void add_read(Group& group, const std::string& name, const std::filesystem::path& path);

}  // namespace golden
