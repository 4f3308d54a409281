// Shared by the engine's tests: meshes as views, slices that are validated at once, contours as text.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/audits.hpp"
#include "engine/rounds.hpp"
#include "engine/shapes.hpp"
#include "lamella/lamella.hpp"
#include "models/models.hpp"

/// A grid on which whole mm are small even numbers: x mm are 2x units, so expected contours can be written down.
inline constexpr double coarse_unit_mm = 0.5;

inline lamella::MeshView view_of(const shapes::Soup& soup) {
    return lamella::MeshView::soup(std::span<const double>(soup));
}
inline lamella::MeshView view_of(const std::vector<float>& soup) {
    return lamella::MeshView::soup(std::span<const float>(soup));
}

/// Planes at these heights: on the coarse grid the plane at h mm is at 2h - 1 units.
lamella::SliceOptions at_heights(std::vector<double> heights_mm, double grid_mm = coarse_unit_mm);

lamella::SliceOptions uniform(double layer_height_mm, double grid_mm = 0);

/// Planes at every quarter of a mm up to `range` mm, so at all corners of random_soup() and between them, on a grid of
/// which a whole mm is a multiple of 8 units.
lamella::SliceOptions through_quarters(std::uint64_t range);

/// A generated mesh of 20 mm.
shapes::Soup generated(lamella::models::Shape shape, std::uint64_t triangles, std::uint64_t seed = 1);

/// Requires success.
void require_ok(const lamella::Status& status);
template <class T>
lamella::Status done(const lamella::Result<T>& result) {
    return result ? lamella::Status() : lamella::Status(result.error());
}
template <class T>
T value_of(lamella::Result<T> result) {
    require_ok(done(result));
    return std::move(result).value();
}

/// The code that a call failed with, or nothing.
template <class Outcome>
std::optional<lamella::ErrorCode> code_of(const Outcome& outcome) {
    return outcome.ok() ? std::nullopt : std::optional(outcome.error().code);
}

/// Requires an error and returns it. Its message must be one line.
template <class Outcome>
lamella::Error error_of(const Outcome& outcome) {
    REQUIRE_FALSE(outcome.ok());
    CHECK_FALSE(outcome.error().message.empty());
    CHECK(outcome.error().message.find('\n') == std::string::npos);
    return outcome.error();
}

/// Slices. Requires success and a valid result.
lamella::SliceResult sliced(const lamella::Source& mesh, const lamella::SliceOptions& options,
                            const lamella::Context& context = {}, const lamella::Tuning& tuning = {});
lamella::SliceResult sliced(const shapes::Soup& soup, const lamella::SliceOptions& options,
                            const lamella::Context& context = {}, const lamella::Tuning& tuning = {});

/// Slices to a destination, by a fresh Slicer. Requires success.
lamella::SliceInfo sliced_to(const lamella::Destination& to, const lamella::Source& mesh,
                             const lamella::SliceOptions& options, const lamella::Context& context = {},
                             const lamella::Tuning& tuning = {});

lamella::Error failure_of(const lamella::Source& mesh, const lamella::SliceOptions& options,
                          const lamella::Context& context = {});

inline const char* word_of(lamella::Role role) {
    constexpr const char* words[] = {"outer", "hole", "flat", "open"};
    return words[static_cast<std::size_t>(role)];
}

/// The contours of one layer, one line each:
///     outer + x8 in -: 0,0 1,0 8,0 ...      role, orientation, segments, parent, marks ("overruled", "mixed"), points
std::vector<std::string> contours_at(const lamella::SliceResult& result, std::size_t layer);
