// Directions in the patient, refusals, and texts: what the files of medical data have in common.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/words.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/result.hpp"

namespace lamella {

using Direction = std::array<double, 3>;

/// Voxels along a side: more fit no mask, whose columns have 31 bits.
inline constexpr std::uint64_t largest_image_side = std::uint64_t{1} << 24;

inline double dot(const Direction& a, const Direction& b) noexcept {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Direction cross(const Direction& a, const Direction& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double length(const Direction& a) noexcept {
    return std::sqrt(dot(a, a));
}

inline Direction scaled(const Direction& a, double factor) noexcept {
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}

/// Precondition: there are some.
inline double median(std::vector<double> of) {
    const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
    std::nth_element(of.begin(), middle, of.end());
    return *middle;
}

/// For messages.
inline std::string rounded_mm(double length) {
    return exact_text(std::round(1000 * length) / 1000) + " mm";
}

/// The axis of the patient that a direction is nearest to, and whether it runs against it.
struct NearestAxis {
    std::size_t axis;
    bool negative;
};

inline NearestAxis nearest_axis(const Direction& a) noexcept {
    const auto* const most =
        std::max_element(a.begin(), a.end(), [](double x, double y) { return std::abs(x) < std::abs(y); });
    return {static_cast<std::size_t>(most - a.begin()), *most < 0};
}

/// Throws Refused: unreadable_file, "cannot read 'NAME': REASON".
[[noreturn]] void refuse_unreadable(const std::string& name, int error_number);
/// Throws Refused: malformed_mesh, "NAME: WHAT".
[[noreturn]] void refuse_image(const std::string& name, const std::string& what);

/// Throws Refused: invalid_argument, "'PATH': WHAT".
[[noreturn]] void refuse_output(const std::filesystem::path& path, const std::string& what);
/// Throws Refused (invalid_argument) unless `result` is cut at so many heights of an image, and has a layer for each of
/// `count` from the first on.
void require_cut(const SliceResult* result, const std::string& name, std::uint64_t heights, std::size_t first = 0,
                 std::size_t count = std::dynamic_extent);

/// A cell of a CSV file: in UTF-8, and quoted where it has to be.
inline std::string csv_text(const std::string& bytes) {
    std::string text = utf8_text(bytes);
    if (text.find_first_of(",\"\r\n") == std::string::npos) {
        return text;
    }
    std::string all = "\"";
    for (const char c : text) {
        all += c == '"' ? "\"\"" : std::string(1, c);
    }
    return all + "\"";
}

/// The geometry of the series of DICOM images with this UID in a folder; of the one there where it is empty. n files:
/// O(n log n). Throws Refused, Stopped and std::bad_alloc.
ImageGeometry read_dicom_folder(const std::filesystem::path& folder, const std::string& series_uid, const StopCheck& stop);

/// The same of one DICOM file, which holds all slices as its frames. Throws Refused and std::bad_alloc.
ImageGeometry read_dicom_file(const std::filesystem::path& path);

/// The geometry that the header of a NIfTI, NRRD or MetaImage file states. Throws Refused and std::bad_alloc.
ImageGeometry read_image_file(const std::filesystem::path& path);

/// Adds a warning where it is.
void warn_of_shear(ImageGeometry& image, const std::string& name);

/// The geometry of voxels that lie `steps` apart from `origin`, in LPS and mm. Throws Refused where the steps are no finite
/// lengths, or those of i and j not perpendicular.
ImageGeometry upright(const std::string& name, const std::array<std::uint64_t, 3>& size,
                      const std::array<Direction, 3>& steps, const Direction& origin);

}  // namespace lamella
