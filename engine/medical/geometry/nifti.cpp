// NIfTI-1: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h says what stands at which byte.
#include <cstring>
#include <limits>

#include "medical/geometry/headers.hpp"

namespace lamella {

namespace {

constexpr std::size_t header_bytes = 348;

/// The header's numbers, in either byte order.
class NiftiHeader {
public:
    explicit NiftiHeader(std::string_view bytes) : bytes_(bytes) {
        swapped_ = number<std::int32_t>(0) != static_cast<std::int32_t>(header_bytes);
    }

    template <class T>
    T number(std::size_t at) const noexcept {
        std::array<char, sizeof(T)> raw{};
        std::copy_n(bytes_.data() + at, sizeof(T), raw.data());
        if (swapped_) {
            std::reverse(raw.begin(), raw.end());
        }
        T value;
        std::memcpy(&value, raw.data(), sizeof value);
        return value;
    }
    double real(std::size_t at) const noexcept { return static_cast<double>(number<float>(at)); }
    std::string_view magic() const noexcept { return bytes_.substr(344, 3); }

private:
    std::string_view bytes_;
    bool swapped_ = false;
};

/// Voxel indices to RAS, in the header's unit: rows of (i, j, k, 1).
using Affine = std::array<std::array<double, 4>, 3>;

Affine sform(const NiftiHeader& header) {
    Affine rows{};
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 4; ++column) {
            rows[row][column] = header.real(280 + 16 * row + 4 * column);
        }
    }
    return rows;
}

Affine qform(const NiftiHeader& header) {
    const double b = header.real(256);
    const double c = header.real(260);
    const double d = header.real(264);
    const double a = std::sqrt(std::max(0.0, 1 - b * b - c * c - d * d));
    const double hand = header.real(76) < 0 ? -1 : 1;
    const std::array<double, 3> step = {header.real(80), header.real(84), hand * header.real(88)};
    Affine rows = {{{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c), header.real(268)},
                    {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b), header.real(272)},
                    {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c, header.real(276)}}};
    for (auto& row : rows) {
        for (std::size_t column = 0; column < 3; ++column) {
            row[column] *= step[column];
        }
    }
    return rows;
}

/// How far apart two affines put a corner of the image, in voxels at most.
double disagreement(const Affine& a, const Affine& b, const std::array<std::uint64_t, 3>& size) {
    double most = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        double squared = 0;
        for (std::size_t row = 0; row < 3; ++row) {
            double difference = a[row][3] - b[row][3];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double index = (corner >> axis & 1) != 0 ? static_cast<double>(size[axis] - 1) : 0;
                difference += (a[row][axis] - b[row][axis]) * index;
            }
            squared += difference * difference;
        }
        most = std::max(most, squared);
    }
    double least_step = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        least_step = std::min(least_step, std::hypot(a[0][axis], a[1][axis], a[2][axis]));
    }
    return std::sqrt(most) / least_step;
}

/// By the lowest bits of xyzt_units; 0, which says nothing, counts as mm.
double mm_per_unit(const NiftiHeader& header, const ImageHeader& file) {
    const int code = header.number<unsigned char>(123) & 7;
    static constexpr std::array<double, 4> mm = {1, 1000, 1, 0.001};
    if (code >= static_cast<int>(mm.size())) {
        file.refuse("its xyzt_units state the unit of length " + std::to_string(code) + "; there is 1 (m), 2 (mm), 3 (um)");
    }
    return mm[static_cast<std::size_t>(code)];
}

}  // namespace

ImageGeometry read_nifti(const ImageHeader& file) {
    if (file.bytes.size() < header_bytes) {
        file.refuse("neither a NIfTI-1 nor an NRRD image");
    }
    const NiftiHeader header(file.bytes);
    if (header.number<std::int32_t>(0) != static_cast<std::int32_t>(header_bytes) ||
        (header.magic() != "n+1" && header.magic() != "ni1")) {
        file.refuse("neither a NIfTI-1 nor an NRRD image");
    }
    const int dimensions = header.number<std::int16_t>(40);
    if (dimensions < 3 || dimensions > 7) {
        file.refuse("an image of " + std::to_string(dimensions) + " dimensions, not of 3");
    }
    std::array<std::uint64_t, 3> size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        size[axis] = static_cast<std::uint64_t>(std::max<int>(header.number<std::int16_t>(42 + 2 * axis), 0));
    }
    const bool by_sform = header.number<std::int16_t>(254) > 0;
    const bool by_qform = header.number<std::int16_t>(252) > 0;
    if (!by_sform && !by_qform) {
        file.refuse("neither its sform nor its qform says where the voxels lie");
    }
    const Affine affine = by_sform ? sform(header) : qform(header);
    const double mm = mm_per_unit(header, file);
    std::array<Direction, 3> steps{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        steps[axis] = {-affine[0][axis] * mm, -affine[1][axis] * mm, affine[2][axis] * mm};
    }
    ImageGeometry image = upright(file.name, size, steps, {-affine[0][3] * mm, -affine[1][3] * mm, affine[2][3] * mm});
    constexpr double unnoticed = 1e-3;  // voxels
    if (by_sform && by_qform && !(disagreement(affine, qform(header), size) <= unnoticed)) {
        image.warnings.push_back(file.name + ": its sform and its qform disagree; the sform holds");
    }
    return image;
}

}  // namespace lamella
