// The headers of image files. NIfTI-1: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h says what stands at which
// byte. NRRD: https://teem.sourceforge.net/nrrd/format.html, lines of "field: value" up to an empty one.
#include <cstring>
#include <functional>
#include <limits>
#include <map>

#include "base/guard.hpp"
#include "io/read/input_file.hpp"
#include "io/text/text.hpp"
#include "medical/geometry/headers.hpp"

namespace lamella {

namespace {

// --- NIfTI-1

constexpr std::size_t header_bytes = 348;

/// Voxel indices to RAS, in the header's unit: rows of (i, j, k, 1).
using Affine = std::array<std::array<double, 4>, 3>;

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

    Affine sform() const noexcept {
        Affine rows{};
        for (std::size_t i = 0; i < 12; ++i) {
            rows[i / 4][i % 4] = real(280 + 4 * i);
        }
        return rows;
    }

    Affine qform() const noexcept {
        const double b = real(256);
        const double c = real(260);
        const double d = real(264);
        const double a = std::sqrt(std::max(0.0, 1 - b * b - c * c - d * d));
        const std::array<double, 3> step = {real(80), real(84), (real(76) < 0 ? -1 : 1) * real(88)};
        Affine rows = {{{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c), real(268)},
                        {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b), real(272)},
                        {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c, real(276)}}};
        for (std::size_t i = 0; i < 9; ++i) {
            rows[i / 3][i % 3] *= step[i % 3];
        }
        return rows;
    }

private:
    std::string_view bytes_;
    bool swapped_ = false;
};

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

// --- NRRD

/// The fields by name. Throws Refused where a line is neither a field, nor a key, nor a comment.
std::map<std::string, std::string, std::less<>> fields_of(const ImageHeader& header) {
    std::map<std::string, std::string, std::less<>> fields;
    std::string_view rest = header.bytes;
    rest.remove_prefix(std::min(rest.find('\n'), rest.size() - 1) + 1);
    for (std::size_t line_number = 2; !rest.empty(); ++line_number) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        const std::string_view line = trimmed(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
        if (line.empty()) {
            return fields;
        }
        if (line.front() == '#' || line.find(":=") != std::string_view::npos) {
            continue;
        }
        const std::size_t colon = line.find(": ");
        if (colon == std::string_view::npos) {
            header.refuse("line " + std::to_string(line_number) + " of the NRRD header is no field");
        }
        fields.emplace(trimmed(line.substr(0, colon)), trimmed(line.substr(colon + 2)));
    }
    return fields;
}

std::vector<std::string_view> words(std::string_view text) {
    std::vector<std::string_view> found;
    for (;;) {
        const std::size_t begin = text.find_first_not_of(" \t");
        if (begin == std::string_view::npos) {
            return found;
        }
        const bool enclosed = text[begin] == '(' || text[begin] == '"';
        const std::size_t stop =
            enclosed ? text.find(text[begin] == '(' ? ')' : '"', begin + 1) : text.find_first_of(" \t", begin);
        const std::size_t end = stop == std::string_view::npos ? text.size() : stop + (enclosed ? 1 : 0);
        found.push_back(text.substr(begin, end - begin));
        text.remove_prefix(end);
    }
}

std::optional<Direction> vector_of(std::string_view text) {
    if (text.size() < 2 || text.front() != '(' || text.back() != ')') {
        return std::nullopt;
    }
    const std::optional<std::vector<double>> found = numbers_in(text.substr(1, text.size() - 2), ',');
    return found && found->size() == 3 ? std::optional<Direction>({(*found)[0], (*found)[1], (*found)[2]}) : std::nullopt;
}

/// Signs that turn the first two coordinates of the space into left and posterior, if it is known.
std::optional<std::array<double, 2>> to_lps(std::string_view space) {
    const auto is = [space](const char* name, const char* letters) { return space == name || space == letters; };
    return is("left-posterior-superior", "LPS")   ? std::optional(std::array<double, 2>{1, 1})
           : is("right-anterior-superior", "RAS") ? std::optional(std::array<double, 2>{-1, -1})
           : is("left-anterior-superior", "LAS")  ? std::optional(std::array<double, 2>{1, -1})
                                                  : std::nullopt;
}

/// NRRD says that units are words, but not which. Without the s of a plural, and as meter, not metre.
// clang-format off
constexpr std::array<std::pair<std::string_view, double>, 15> units = {{
    {"", 1}, {"mm", 1}, {"millimeter", 1}, {"cm", 10}, {"centimeter", 10}, {"m", 1000}, {"meter", 1000}, {"in", 25.4}, {"inch", 25.4},
    {"nm", 1e-6}, {"um", 0.001}, {"micron", 0.001}, {"micrometer", 0.001},
    {"\xc2\xb5m", 0.001}, {"\xce\xbcm", 0.001},  // the sign for micro, the Greek letter
}};
// clang-format on

double mm_of(std::string_view text, const ImageHeader& header) {
    std::string name = lower_case(trimmed(text, "\" \t"));
    if (name.size() > 3 && name.back() == 's') {
        name.resize(name.size() - (name == "inches" ? 2 : 1));
    }
    if (name.ends_with("metre")) {
        name.replace(name.size() - 2, 2, "er");
    }
    for (const auto& [known, mm] : units) {
        if (name == known) {
            return mm;
        }
    }
    header.refuse("its unit " + printable(std::string(text)) + " is not known; there is mm, um, nm, cm, m, in");
}

}  // namespace

ImageGeometry read_nifti(const ImageHeader& file) {
    if (file.bytes.size() < header_bytes) {
        file.refuse("neither a NIfTI-1 nor an NRRD image");
    }
    const NiftiHeader header(file.bytes);
    const std::string_view magic = std::string_view(file.bytes).substr(344, 3);
    if (header.number<std::int32_t>(0) != static_cast<std::int32_t>(header_bytes) || (magic != "n+1" && magic != "ni1")) {
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
    const Affine affine = by_sform ? header.sform() : header.qform();
    // The lowest bits of xyzt_units; 0, which says nothing, counts as mm.
    const int unit = header.number<unsigned char>(123) & 7;
    static constexpr std::array<double, 4> mm_of_unit = {1, 1000, 1, 0.001};
    if (unit >= static_cast<int>(mm_of_unit.size())) {
        file.refuse("its xyzt_units state the unit of length " + std::to_string(unit) + "; there is 1 (m), 2 (mm), 3 (um)");
    }
    const double mm = mm_of_unit[static_cast<std::size_t>(unit)];
    std::array<Direction, 3> steps{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        steps[axis] = {-affine[0][axis] * mm, -affine[1][axis] * mm, affine[2][axis] * mm};
    }
    ImageGeometry image = upright(file.name, size, steps, {-affine[0][3] * mm, -affine[1][3] * mm, affine[2][3] * mm});
    constexpr double unnoticed = 1e-3;  // voxels
    if (by_sform && by_qform && !(disagreement(affine, header.qform(), size) <= unnoticed)) {
        image.warnings.push_back(file.name + ": its sform and its qform disagree; the sform holds");
    }
    return image;
}

ImageGeometry read_nrrd(const ImageHeader& header) {
    const auto fields = fields_of(header);
    const auto field = [&](std::string_view name) {
        const auto found = fields.find(name);
        return found == fields.end() ? std::string_view() : std::string_view(found->second);
    };
    const std::optional<std::array<double, 2>> sign = to_lps(field("space"));
    if (!sign) {
        header.refuse("its space is " + (field("space").empty() ? "not stated" : "'" + std::string(field("space")) + "'") +
                      "; there is left-posterior-superior, right-anterior-superior, left-anterior-superior");
    }
    const std::vector<std::string_view> sizes = words(field("sizes"));
    const std::vector<std::string_view> directions = words(field("space directions"));
    const std::optional<Direction> origin = vector_of(field("space origin"));
    if (sizes.size() != directions.size() || !origin) {
        header.refuse("its sizes, space directions and space origin do not say where the voxels lie");
    }
    const std::vector<std::string_view> space_units = words(field("space units"));
    Direction mm = {1, 1, 1};
    if (!space_units.empty() && space_units.size() != mm.size()) {
        header.refuse("its space units are " + std::to_string(space_units.size()) + ", not one for each of 3 axes");
    }
    std::transform(space_units.begin(), space_units.end(), mm.begin(),
                   [&](std::string_view unit) { return mm_of(unit, header); });
    const std::vector<std::string_view> axis_units = words(field("units"));
    const auto in_lps = [&](const Direction& at) {
        return Direction{(*sign)[0] * mm[0] * at[0], (*sign)[1] * mm[1] * at[1], mm[2] * at[2]};
    };
    std::array<std::uint64_t, 3> size{};
    std::array<Direction, 3> steps{};
    std::size_t axes = 0;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        const std::optional<Direction> step = vector_of(directions[i]);
        if (!step && directions[i] == "none") {
            continue;  // a list, as of the parts of a colour
        }
        if (!step || axes == 3 || !read_integer(sizes[i], size[axes])) {
            header.refuse("its sizes or space directions are not those of an image of three dimensions");
        }
        if (i < axis_units.size() && space_units.empty() && mm_of(axis_units[i], header) != 1) {
            header.refuse("its units state " + printable(std::string(axis_units[i])) +
                          ", but hold for no axis with a space direction; state 'space units'");
        }
        steps[axes++] = in_lps(*step);
    }
    if (axes != 3) {
        header.refuse("an image of " + std::to_string(axes) + " dimensions, not of 3");
    }
    return upright(header.name, size, steps, in_lps(*origin));
}

}  // namespace lamella
