// The committed hashes, hashes.txt: one line "HASH NAME" each. Names of a group begin with "GROUP: ".
//
// A test case owns one group: it computes all hashes, and check_golden() compares them with the group's lines. With
// LAMELLA_UPDATE_GOLDEN set in the environment the lines are rewritten instead:
//
//     LAMELLA_UPDATE_GOLDEN=1 build/tests/lamella_tests "[golden]"      (one process: every group rewrites the file)
//
// Inputs have hashes of their own, those named "input: ..." and "file: ...": where a compiler or a C library makes another
// mesh, their group fails beside those of the results. Times, threads, bands and paths are left out: they are not part of
// what is promised.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/numbers.hpp"
#include "engine/slicing.hpp"
#include "golden/inputs.hpp"
#include "lamella/lamella.hpp"

namespace golden {

/// FNV-1a over 8-byte words, and the bytes of text. Not the engine's own hash, so that a bug in that one is seen too.
class Hash {
public:
    /// Integers, doubles by their bits, points, ranges of such, and text.
    template <class... Values>
    Hash& add(const Values&... values) noexcept {
        (one(values), ...);
        return *this;
    }
    std::uint64_t value() const noexcept { return value_; }

private:
    template <class Value>
    void one(const Value& value) noexcept {
        if constexpr (std::is_integral_v<Value>) {
            for (int shift = 0; shift < 64; shift += 8) {
                byte(static_cast<std::uint64_t>(value) >> shift & 0xFF);
            }
        } else if constexpr (std::is_floating_point_v<Value>) {
            one(lamella::bits_as<std::uint64_t>(value));
        } else if constexpr (std::is_convertible_v<Value, std::string_view>) {
            const std::string_view text = value;
            one(text.size());
            std::for_each(text.begin(), text.end(), [&](char c) { byte(static_cast<unsigned char>(c)); });
        } else if constexpr (std::is_same_v<Value, lamella::Point>) {
            add(value.x, value.y);
        } else {
            std::for_each(value.begin(), value.end(), [&](const auto& item) { one(item); });
        }
    }
    void byte(std::uint64_t byte) noexcept { value_ = (value_ ^ byte) * 0x100000001B3; }

    std::uint64_t value_ = 0xCBF29CE484222325;
};

inline std::uint64_t hash_of(std::span<const double> numbers) {
    return Hash().add(numbers).value();
}
inline std::uint64_t hash_of(std::string_view bytes) {
    return Hash().add(bytes).value();
}

std::uint64_t hash_of(const lamella::Ledger& ledger);
std::uint64_t hash_of(const lamella::VolumeCertificate& volume);
std::uint64_t hash_of(const lamella::Crossings& crossings);
/// The counts: not the findings and shells.
std::uint64_t hash_of(const lamella::MeshCheck& mesh);

/// By name within the group.
using Hashes = std::map<std::string, std::uint64_t>;

/// Names are distinct.
void add(Hashes& hashes, const std::string& name, std::uint64_t hash);

/// These must be the lines whose names begin with "`group`: ", or those without any such beginning if it is empty.
void check_golden(const std::string& group, const Hashes& produced);

using Options = lamella::SliceOptions;
using Rule = lamella::FillRule;

/// The same options but for one thing.
template <class Change>
Options changed(Options options, const Change& change) {
    change(options);
    return options;
}
inline Options above(const Options& options) {
    return changed(options, [](Options& it) { it.planes.side = lamella::PlaneSide::above; });
}
inline Options filled(Rule rule, const Options& options) {
    return changed(options, [&](Options& it) { it.region.fill_rule = rule; });
}
inline Options stitched(double reach_mm, const Options& options) {
    return changed(options, [&](Options& it) { it.stitch_mm = reach_mm; });
}
inline Options on_grid(double grid_mm, const Options& options) {
    return changed(options, [&](Options& it) { it.frame.grid_mm = grid_mm; });
}
inline Options turned(double x, double y, double z, const Options& options) {
    return changed(options, [&](Options& it) { it.frame.transform = lamella::Transform::from_normal(x, y, z); });
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
    std::vector<std::byte> strided_;
};

/// Every field of contours, and points.
Hash& add_contours(Hash& hash, std::span<const lamella::Contour> contours, std::span<const lamella::Point> points);

/// Adds "NAME" (planes, contours and points) and "NAME, numbers" (heights, areas, stitches, counts, box), which must be
/// the same on 1 and more threads, in bands of 1 and more planes and of the default number, and in both forms of
/// construction. Returns the most bands that there were by default.
std::uint64_t add_slices(Hashes& hashes, const std::string& name, const lamella::MeshView& mesh, const Options& options,
                         lamella::Tuning tuning = {});

}  // namespace golden
