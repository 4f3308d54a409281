#include "medical/geometry/headers.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <memory>
#include <string_view>
#include <system_error>

#include <zlib.h>

#include "base/guard.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_header_bytes = std::size_t{1} << 20;
constexpr double largest_cosine = 1e-4;  ///< of axes that count as perpendicular

constexpr std::array<const char*, 3> axis_names = {"i", "j", "k"};

/// Which ends a header of text.
bool has_blank_line(std::string_view text) {
    return text.find("\n\n") != std::string_view::npos || text.find("\n\r\n") != std::string_view::npos;
}

}  // namespace

Error ImageHeader::refused(const std::string& what) const {
    return malformed_image(name, what);
}

ImageHeader read_image_header(const std::filesystem::path& path) {
    ImageHeader header{path.string(), {}};
    std::error_code unknown;
    if (std::filesystem::is_directory(path, unknown)) {
        throw Refused{unreadable(header.name, EISDIR)};
    }
    errno = 0;
    const std::unique_ptr<gzFile_s, decltype(&::gzclose)> file(::gzopen(path.c_str(), "rb"), &::gzclose);
    if (file == nullptr) {
        throw Refused{unreadable(header.name, errno != 0 ? errno : ENOMEM)};
    }
    // Nothing beyond the header is read: it may be a mask of a hundred million voxels.
    std::string& bytes = header.bytes;
    std::array<char, 4096> piece{};
    int count = 0;
    do {
        count = ::gzread(file.get(), piece.data(), piece.size());
        bytes.append(piece.data(), static_cast<std::size_t>(std::max(count, 0)));
    } while (count > 0 && bytes.size() < most_header_bytes && bytes.starts_with("NRRD") && !has_blank_line(bytes));
    if (count < 0) {
        throw Refused{header.refused("damaged gzip data within the header")};
    }
    return header;
}

Error unreadable(const std::string& name, int error_number) {
    return {.code = ErrorCode::unreadable_file,
            .message = "cannot read '" + name + "': " + std::generic_category().message(error_number)};
}

Error malformed_image(const std::string& name, const std::string& what) {
    return {.code = ErrorCode::malformed_mesh, .message = name + ": " + what};
}

ImageGeometry upright(const std::string& name, const std::array<std::uint64_t, 3>& size,
                      const std::array<Direction, 3>& steps, const Direction& origin) {
    ImageGeometry image;
    image.size = size;
    image.origin_mm = origin;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double step = length(steps[axis]);
        if (!std::isfinite(step) || step <= 0 || !std::isfinite(origin[axis])) {
            throw Refused{malformed_image(name, "the distance of voxels along " + std::string(axis_names[axis]) +
                                                    ", or the origin, is no finite length")};
        }
        if (size[axis] == 0 || size[axis] > largest_image_side) {
            throw Refused{malformed_image(name, std::to_string(size[axis]) + " voxels along " + axis_names[axis])};
        }
        image.spacing_mm[axis] = step;
        image.axes[axis] = scaled(steps[axis], 1 / step);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t next = (axis + 1) % 3;
        if (std::abs(dot(image.axes[axis], image.axes[next])) > largest_cosine) {
            throw Refused{malformed_image(name, "sheared: the axes " + std::string(axis_names[axis]) + " and " +
                                                    axis_names[next] + " are not perpendicular")};
        }
    }
    // Axes are made exactly perpendicular: the header rounds them.
    const Direction normal = cross(image.axes[0], image.axes[1]);
    const Direction upright_k = scaled(normal, (dot(normal, image.axes[2]) < 0 ? -1 : 1) / length(normal));
    image.axes[1] = scaled(cross(normal, image.axes[0]), 1 / length(normal));
    image.axes[2] = upright_k;
    return image;
}

}  // namespace lamella
