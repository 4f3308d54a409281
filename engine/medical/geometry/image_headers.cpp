// Where NIfTI, NRRD and MetaImage headers say that the voxels of an image lie.
#include <cerrno>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <memory>

#include <zlib.h>

#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "base/words.hpp"
#include "io/text/text.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

namespace {

constexpr std::size_t most_header_bytes = std::size_t{1} << 20;

/// The first bytes of a file, or of what gzip holds.
struct ImageHeader {
    std::string name;
    std::string bytes;

    [[noreturn]] void refuse(const std::string& what) const { refuse_image(name, what); }
};

/// A header of MetaImage: it begins with a line "Key = Value".
bool is_meta_image(std::string_view bytes) {
    const std::string_view line = bytes.substr(0, std::min(bytes.find('\n'), bytes.size()));
    const std::string_view key = trimmed(line.substr(0, std::min(line.find('='), line.size())));
    return key.size() < line.size() && !key.empty() &&
           std::all_of(key.begin(), key.end(), [](char c) { return c >= 'A' && c <= 'z'; });
}

/// Whether the text of a header goes on beyond `bytes`.
bool goes_on(const std::string& bytes) {
    return bytes.starts_with("NRRD") ? bytes.find("\n\n") == std::string::npos && bytes.find("\n\r\n") == std::string::npos
                                     : is_meta_image(bytes) && bytes.find("\nElementDataFile") == std::string::npos;
}

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
    } while (count > 0 && bytes.size() < most_header_bytes && goes_on(bytes));
    if (count < 0) {
        header.refuse("damaged gzip data within the header");
    }
    return header;
}

// --- NIfTI: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h and nifti2.h say what stands at which byte

/// Voxel indices to RAS, in the header's unit: rows of (i, j, k, 1).
using Affine = std::array<std::array<double, 4>, 3>;

/// The header's numbers, in either byte order. Where two places are given, the second is NIfTI-2's.
class NiftiHeader {
public:
    explicit NiftiHeader(std::string_view bytes) : bytes_(bytes) {}

    /// Finds the version and the byte order. Returns whether it is such a header.
    bool identify() noexcept {
        for (const bool swapped : {false, true}) {
            swapped_ = swapped;
            const auto bytes = bytes_.size() < 4 ? 0 : number<std::int32_t>(0);
            wide_ = bytes == 540;
            if ((bytes == 348 || wide_) && bytes_.size() >= static_cast<std::size_t>(bytes)) {
                const std::string_view magic = bytes_.substr(wide_ ? 4 : 344, 3);
                return wide_ ? magic == "n+2" || magic == "ni2" : magic == "n+1" || magic == "ni1";
            }
        }
        return false;
    }

    std::int64_t dim(std::size_t i) const noexcept {
        return wide_ ? number<std::int64_t>(16 + 8 * i) : number<std::int16_t>(40 + 2 * i);
    }
    bool by_qform() const noexcept { return (wide_ ? number<std::int32_t>(344) : number<std::int16_t>(252)) > 0; }
    bool by_sform() const noexcept { return (wide_ ? number<std::int32_t>(348) : number<std::int16_t>(254)) > 0; }
    /// The lowest bits of xyzt_units; 0 says nothing.
    int length_unit() const noexcept { return (wide_ ? number<std::int32_t>(500) : number<unsigned char>(123)) & 7; }

    Affine sform() const noexcept {
        Affine rows{};
        for (std::size_t i = 0; i < 12; ++i) {
            rows[i / 4][i % 4] = real(280, 400, i);
        }
        return rows;
    }

    Affine qform() const noexcept {
        const double b = real(256, 352, 0);
        const double c = real(256, 352, 1);
        const double d = real(256, 352, 2);
        const double a = std::sqrt(std::max(0.0, 1 - b * b - c * c - d * d));
        const double hand = real(76, 104, 0) < 0 ? -1 : 1;
        const std::array<double, 3> step = {real(76, 104, 1), real(76, 104, 2), hand * real(76, 104, 3)};
        Affine rows = {{{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c), real(268, 376, 0)},
                        {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b), real(268, 376, 1)},
                        {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c, real(268, 376, 2)}}};
        for (std::size_t i = 0; i < 9; ++i) {
            rows[i / 3][i % 3] *= step[i % 3];
        }
        return rows;
    }

private:
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
    double real(std::size_t one, std::size_t two, std::size_t i) const noexcept {
        return wide_ ? number<double>(two + 8 * i) : static_cast<double>(number<float>(one + 4 * i));
    }

    std::string_view bytes_;
    bool swapped_ = false;
    bool wide_ = false;
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

// --- NRRD: https://teem.sourceforge.net/nrrd/format.html, lines of "field: value" up to an empty one. MetaImage:
// https://docs.itk.org/en/latest/learn/metaio.html, lines of "Key = Value" up to ElementDataFile

using TextFields = std::map<std::string, std::string, std::less<>>;

/// The values by their fields or keys; the first of several. Throws Refused where a line is none.
TextFields fields_of(const ImageHeader& header) {
    const bool is_nrrd = header.bytes.starts_with("NRRD");
    const std::string_view separator = is_nrrd ? ": " : "=";
    std::string_view left = header.bytes;
    TextFields fields;
    bool ended = false;
    for (std::size_t number = 1; !left.empty() && !ended; ++number) {
        const std::size_t end = std::min(left.find('\n'), left.size());
        const std::string_view line = trimmed(left.substr(0, end));
        left.remove_prefix(std::min(end + 1, left.size()));
        const std::size_t at = line.find(separator);
        const bool other = is_nrrd && (number == 1 || line.starts_with('#') || line.find(":=") != std::string_view::npos);
        if (!line.empty() && !other) {
            if (at == std::string_view::npos) {
                header.refuse("line " + std::to_string(number) + " of its header is no field with a value");
            }
            fields.emplace(trimmed(line.substr(0, at)), trimmed(line.substr(at + separator.size())));
        }
        ended = is_nrrd ? line.empty() : fields.contains("ElementDataFile");
    }
    if (!ended && !is_nrrd) {
        header.refuse("its MetaImage header does not end with ElementDataFile");
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
    NiftiHeader header(file.bytes);
    if (!header.identify()) {
        file.refuse("neither a NIfTI, an NRRD nor a MetaImage file");
    }
    const std::int64_t dimensions = header.dim(0);
    if (dimensions < 3 || dimensions > 7) {
        file.refuse("an image of " + std::to_string(dimensions) + " dimensions, not of 3");
    }
    std::array<std::uint64_t, 3> size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        size[axis] = static_cast<std::uint64_t>(std::max<std::int64_t>(header.dim(axis + 1), 0));
    }
    const bool by_sform = header.by_sform();
    if (!by_sform && !header.by_qform()) {
        file.refuse("neither its sform nor its qform says where the voxels lie");
    }
    const Affine affine = by_sform ? header.sform() : header.qform();
    const int unit = header.length_unit();
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
    if (by_sform && header.by_qform() && !(disagreement(affine, header.qform(), size) <= unnoticed)) {
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

/// The numbers of the first of these keys that is there; nothing where none is. Throws Refused unless they are `count`.
std::optional<std::vector<double>> key_numbers(const TextFields& keys, std::initializer_list<std::string_view> names,
                                               std::size_t count, const ImageHeader& header) {
    for (const std::string_view name : names) {
        if (const auto found = keys.find(name); found != keys.end()) {
            std::vector<double> numbers;
            bool all = true;
            for (const std::string_view word : words(found->second)) {
                const std::optional<double> number = parse_number(word);
                all = all && number;
                numbers.push_back(number.value_or(0));
            }
            if (!all || numbers.size() != count) {
                header.refuse("its " + std::string(name) + " is not " + counted(count, "number"));
            }
            return numbers;
        }
    }
    return std::nullopt;
}

/// Directions and places are in LPS, whatever AnatomicalOrientation says.
ImageGeometry read_meta_image(const ImageHeader& header) {
    const TextFields keys = fields_of(header);
    const double dimensions = key_numbers(keys, {"NDims"}, 1, header).value_or(std::vector{0.0})[0];
    if (dimensions != 3 && dimensions != 4) {
        header.refuse("an image of " + exact_text(dimensions) + " dimensions, not of 3");
    }
    const auto count = static_cast<std::size_t>(dimensions);
    const auto sizes = key_numbers(keys, {"DimSize"}, count, header);
    const auto spacing = key_numbers(keys, {"ElementSpacing"}, count, header);
    const auto origin = key_numbers(keys, {"Offset", "Position", "Origin"}, count, header);
    const auto matrix = key_numbers(keys, {"TransformMatrix", "Orientation", "Rotation"}, count * count, header);
    if (!sizes || !spacing || !origin) {
        header.refuse("its DimSize, ElementSpacing and Offset do not say where the voxels lie");
    }
    if (count == 4 && sizes->back() != 1) {
        header.refuse("an image of 4 dimensions, not of 3");
    }
    std::array<std::uint64_t, 3> size{};
    std::array<Direction, 3> steps = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double side = (*sizes)[axis];
        size[axis] = side >= 0 && side < 1e18 ? static_cast<std::uint64_t>(side) : 0;
        for (std::size_t i = 0; matrix && i < 3; ++i) {  // its rows are the directions of i, j and k
            steps[axis][i] = (*matrix)[axis * count + i];
        }
        steps[axis] = scaled(steps[axis], (*spacing)[axis]);
    }
    ImageGeometry image = upright(header.name, size, steps, {(*origin)[0], (*origin)[1], (*origin)[2]});
    if (image.is_sheared()) {
        header.refuse("sheared: its axis k is not perpendicular to i and j, which some readers of MetaImage pass over");
    }
    return image;
}

}  // namespace

ImageGeometry read_image_file(const std::filesystem::path& path) {
    const ImageHeader header = read_image_header(path);
    if (header.bytes.size() > 132 && header.bytes.compare(128, 4, "DICM") == 0) {
        return read_dicom_file(path);
    }
    return header.bytes.starts_with("NRRD") ? read_nrrd(header)
           : is_meta_image(header.bytes)    ? read_meta_image(header)
                                            : read_nifti(header);
}

}  // namespace lamella
