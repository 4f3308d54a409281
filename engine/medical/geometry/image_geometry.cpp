#include "lamella/medical/geometry.hpp"

#include <cerrno>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <memory>

#include <zlib.h>

#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "io/text/text.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

Transform ImageGeometry::slicing_frame(PatientFrame frame) const noexcept {
    const std::array<std::array<double, 3>, 3> rows = {axes[0], axes[1], cross(axes[0], axes[1])};
    const double mirror = frame == PatientFrame::ras ? -1 : 1;  // of the first two coordinates: RAS to LPS
    Transform to;
    for (std::size_t row = 0; row < 3; ++row) {
        to.m[4 * row] = mirror * rows[row][0];
        to.m[4 * row + 1] = mirror * rows[row][1];
        to.m[4 * row + 2] = rows[row][2];
        to.m[4 * row + 3] = -dot(rows[row], origin_mm);
    }
    return to;
}

std::vector<double> ImageGeometry::slice_heights_mm(int subslices) const {
    const double hand = dot(axes[2], cross(axes[0], axes[1])) < 0 ? -1 : 1;
    const auto centre = [&](std::uint64_t slice) {
        return slice < uneven_slices_mm.size() ? uneven_slices_mm[slice] : static_cast<double>(slice) * spacing_mm[2];
    };
    std::vector<double> heights;
    for (std::uint64_t slice = 0; slice < size[2]; ++slice) {
        for (int part = 0; part < subslices; ++part) {
            heights.push_back(hand * (centre(slice) + ((part + 0.5) / subslices - 0.5) * spacing_mm[2]));
        }
    }
    return heights;
}

std::array<double, 3> ImageGeometry::to_lps(const std::array<double, 3>& sliced_mm) const noexcept {
    const Direction normal = cross(axes[0], axes[1]);
    std::array<double, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) {
        at[i] = origin_mm[i] + axes[0][i] * sliced_mm[0] + axes[1][i] * sliced_mm[1] + normal[i] * sliced_mm[2];
    }
    return at;
}

std::size_t ImageGeometry::slice_axis() const noexcept {
    return nearest_axis(cross(axes[0], axes[1])).axis;
}

double ImageGeometry::height_lps_mm(double height_mm) const noexcept {
    const Direction normal = cross(axes[0], axes[1]);
    const double along = dot(normal, origin_mm) + height_mm;
    return nearest_axis(normal).negative ? -along : along;
}

namespace {

constexpr double largest_voxel_mm = 1e6;  ///< coordinates end at 1e9
constexpr double rounding = 1e-3;         ///< of a voxel

constexpr std::size_t most_header_bytes = std::size_t{1} << 20;
constexpr double largest_cosine = 1e-4;  ///< of axes that count as perpendicular

constexpr std::array<const char*, 3> axis_names = {"i", "j", "k"};

/// The first bytes of a file, or of what gzip holds.
struct ImageHeader {
    std::string name;
    std::string bytes;

    [[noreturn]] void refuse(const std::string& what) const { refuse_image(name, what); }
};

ImageHeader read_image_header(const std::filesystem::path& path) {
    ImageHeader header{path_text(path), {}};
    errno = 0;
#ifdef _WIN32
    const gzFile opened = ::gzopen_w(system_path(path).c_str(), "rb");
#else
    const gzFile opened = ::gzopen(path.c_str(), "rb");
#endif
    const std::unique_ptr<gzFile_s, decltype(&::gzclose)> file(opened, &::gzclose);
    if (file == nullptr) {
        refuse_unreadable(header.name, errno != 0 ? errno : ENOMEM);
    }
    // Nothing beyond the header is read: it may be a mask of a hundred million voxels.
    std::string& bytes = header.bytes;
    std::array<char, 4096> piece{};
    int count = 0;
    do {
        count = ::gzread(file.get(), piece.data(), piece.size());
        bytes.append(piece.data(), static_cast<std::size_t>(std::max(count, 0)));
    } while (count > 0 && bytes.size() < most_header_bytes && bytes.starts_with("NRRD") &&
             bytes.find("\n\n") == std::string::npos && bytes.find("\n\r\n") == std::string::npos);
    if (count < 0) {
        header.refuse("damaged gzip data within the header");
    }
    return header;
}

// --- NIfTI-1: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h says what stands at which byte

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

/// How far apart two affines put the origin or the end of an axis, in voxels at most.
double disagreement(const Affine& a, const Affine& b, const std::array<std::uint64_t, 3>& size) {
    double most = 0;
    double least_step = std::numeric_limits<double>::infinity();
    for (std::size_t column = 0; column < 4; ++column) {
        const double voxels = column < 3 ? static_cast<double>(size[column] - 1) : 1;
        const auto difference = [&](std::size_t row) { return voxels * (a[row][column] - b[row][column]); };
        most = std::max(most, std::hypot(difference(0), difference(1), difference(2)));
        least_step = std::min(least_step, column < 3 ? std::hypot(a[0][column], a[1][column], a[2][column]) : least_step);
    }
    return most / least_step;
}

// --- NRRD: https://teem.sourceforge.net/nrrd/format.html, lines of "field: value" up to an empty one

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

/// Of which each ends at a blank, or encloses some by parentheses or quotes.
std::vector<std::string_view> words(std::string_view text) {
    std::vector<std::string_view> found;
    while (!(text = trimmed(text)).empty()) {
        const bool enclosed = text.front() == '(' || text.front() == '"';
        const std::size_t stop = enclosed ? text.find(text.front() == '(' ? ')' : '"', 1) : text.find_first_of(" \t");
        const std::size_t end = stop == std::string_view::npos ? text.size() : stop + (enclosed ? 1 : 0);
        found.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    return found;
}

std::optional<Direction> vector_of(std::string_view text) {
    if (text.size() < 2 || text.front() != '(' || text.back() != ')') {
        return std::nullopt;
    }
    const std::optional<std::vector<double>> found = parse_numbers(text.substr(1, text.size() - 2), ',');
    return found && found->size() == 3 ? std::optional<Direction>({(*found)[0], (*found)[1], (*found)[2]}) : std::nullopt;
}

/// Signs that turn the coordinates of the space into left, posterior and superior, if it is known.
std::optional<Direction> to_lps(std::string_view space) {
    const auto is = [space](const char* name, const char* letters) { return space == name || space == letters; };
    return is("left-posterior-superior", "LPS")   ? std::optional(Direction{1, 1, 1})
           : is("right-anterior-superior", "RAS") ? std::optional(Direction{-1, -1, 1})
           : is("left-anterior-superior", "LAS")  ? std::optional(Direction{1, -1, 1})
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
    const std::optional<Direction> sign = to_lps(field("space"));
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
    if (!space_units.empty() && space_units.size() != 3) {
        header.refuse("its space units are " + std::to_string(space_units.size()) + ", not one for each of 3 axes");
    }
    const std::vector<std::string_view> axis_units = words(field("units"));
    const auto in_lps = [&](Direction at) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            at[axis] *= (*sign)[axis] * (space_units.empty() ? 1 : mm_of(space_units[axis], header));
        }
        return at;
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

}  // namespace

Result<ImageGeometry> geometry_around(const Box& box, const std::array<double, 3>& spacing_mm) noexcept {
    return guarded([&]() -> Result<ImageGeometry> {
        ImageGeometry image;
        image.spacing_mm = spacing_mm;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double spacing = spacing_mm[axis];
            if (!(spacing > 0 && spacing <= largest_voxel_mm)) {
                return Error{ErrorCode::invalid_argument, "a voxel's size must be a number of mm above 0, and at most 1e6"};
            }
            const double extent = box.max_mm[axis] - box.min_mm[axis];
            const double needed = std::ceil(extent / spacing - rounding);
            const double count = std::max(1.0, needed);
            if (!(needed >= 0 && needed <= static_cast<double>(largest_image_side))) {
                return Error{ErrorCode::invalid_argument, "voxels of that size are too many around the mesh"};
            }
            const double middle = box.min_mm[axis] + extent / 2;
            const double origin = middle - (count - 1) / 2 * spacing;
            const auto as_float = static_cast<double>(static_cast<float>(origin));  // where that is next to nothing
            image.origin_mm[axis] = std::abs(as_float - origin) <= rounding * spacing ? as_float : origin;
            image.size[axis] = static_cast<std::uint64_t>(count);
        }
        return image;
    });
}

void refuse_unreadable(const std::string& name, int error_number) {
    throw Refused{
        {.code = ErrorCode::unreadable_file, .message = "cannot read '" + name + "': " + system_message(error_number)}};
}

void refuse_image(const std::string& name, const std::string& what) {
    throw Refused{{.code = ErrorCode::malformed_mesh, .message = name + ": " + what}};
}

void refuse_output(const std::filesystem::path& path, const std::string& what) {
    throw Refused{{ErrorCode::invalid_argument, "'" + path_text(path) + "': " + what}};
}

void require_cut(const SliceResult* result, const std::string& name, std::uint64_t heights) {
    const auto is_there = [&](std::uint64_t layer) { return layer < result->layers.size(); };
    if (result == nullptr || result->info.layer_of.size() != heights ||
        !std::all_of(result->info.layer_of.begin(), result->info.layer_of.end(), is_there)) {
        throw Refused{{ErrorCode::invalid_argument, "'" + name + "' was not cut at the slices of the image"}};
    }
}

ImageGeometry upright(const std::string& name, const std::array<std::uint64_t, 3>& size,
                      const std::array<Direction, 3>& steps, const Direction& origin) {
    ImageGeometry image;
    image.size = size;
    image.origin_mm = origin;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double step = length(steps[axis]);
        if (!std::isfinite(step) || step <= 0 || !std::isfinite(origin[axis])) {
            refuse_image(name, "the distance of voxels along " + std::string(axis_names[axis]) +
                                   ", or the origin, is no finite length");
        }
        if (size[axis] == 0 || size[axis] > largest_image_side) {
            refuse_image(name, std::to_string(size[axis]) + " voxels along " + axis_names[axis]);
        }
        image.spacing_mm[axis] = step;
        image.axes[axis] = scaled(steps[axis], 1 / step);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t next = (axis + 1) % 3;
        if (std::abs(dot(image.axes[axis], image.axes[next])) > largest_cosine) {
            refuse_image(name, "sheared: the axes " + std::string(axis_names[axis]) + " and " + axis_names[next] +
                                   " are not perpendicular");
        }
    }
    // Axes are made exactly perpendicular: the header rounds them.
    const Direction normal = cross(image.axes[0], image.axes[1]);
    const Direction upright_k = scaled(normal, (dot(normal, image.axes[2]) < 0 ? -1 : 1) / length(normal));
    image.axes[1] = scaled(cross(normal, image.axes[0]), 1 / length(normal));
    image.axes[2] = upright_k;
    return image;
}

Result<ImageGeometry> read_image_geometry(const std::filesystem::path& path) noexcept {
    return guarded([&]() -> Result<ImageGeometry> {
        std::error_code unknown;
        if (std::filesystem::is_directory(path, unknown)) {
            return read_dicom_folder(path);
        }
        const ImageHeader header = read_image_header(path);
        if (header.bytes.size() > 132 && header.bytes.compare(128, 4, "DICM") == 0) {
            header.refuse("one DICOM file; name the folder that holds its series");
        }
        return header.bytes.starts_with("NRRD") ? read_nrrd(header) : read_nifti(header);
    });
}

}  // namespace lamella
