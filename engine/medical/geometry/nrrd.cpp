// NRRD headers: https://teem.sourceforge.net/nrrd/format.html. Lines of "field: value" up to an empty one.
#include <functional>
#include <map>

#include "base/guard.hpp"
#include "io/read/input_file.hpp"
#include "io/text/text.hpp"
#include "medical/geometry/headers.hpp"

namespace lamella {

namespace {

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

struct NamedUnit {
    std::string_view name;
    double mm;
};

/// NRRD says that units are words, but not which. Without the s of a plural, and as meter, not metre.
// clang-format off
constexpr std::array<NamedUnit, 15> units = {{
    {"", 1}, {"mm", 1}, {"millimeter", 1}, {"cm", 10}, {"centimeter", 10}, {"m", 1000}, {"meter", 1000}, {"in", 25.4}, {"inch", 25.4},
    {"nm", 1e-6}, {"um", 0.001}, {"micron", 0.001}, {"micrometer", 0.001},
    {"\xc2\xb5m", 0.001}, {"\xce\xbcm", 0.001},  // the sign for micro, the Greek letter
}};
// clang-format on

/// A unit as it stands in the table.
std::string unit_name(std::string_view text) {
    if (text.size() > 1 && text.front() == '"') {
        text = text.substr(1, text.size() - 2);
    }
    std::string name = lower_case(trimmed(text));
    if (name.size() > 3 && name.back() == 's') {
        name.resize(name.size() - (name == "inches" ? 2 : 1));
    }
    if (name.ends_with("metre")) {
        name.replace(name.size() - 2, 2, "er");
    }
    return name;
}

double mm_of(std::string_view text, const ImageHeader& header) {
    const std::string name = unit_name(text);
    const auto* const unit =
        std::find_if(units.begin(), units.end(), [&](const NamedUnit& known) { return known.name == name; });
    if (unit == units.end()) {
        header.refuse("its unit " + printable(std::string(text)) + " is not known; there is mm, um, nm, cm, m, in");
    }
    return unit->mm;
}

/// mm of the unit of each axis of the space.
Direction units_of_space(std::string_view field, const ImageHeader& header) {
    const std::vector<std::string_view> names = words(field);
    Direction mm = {1, 1, 1};
    if (!names.empty() && names.size() != mm.size()) {
        header.refuse("its space units are " + std::to_string(names.size()) + ", not one for each of 3 axes");
    }
    std::transform(names.begin(), names.end(), mm.begin(), [&](std::string_view name) { return mm_of(name, header); });
    return mm;
}

}  // namespace

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
    const Direction mm = units_of_space(field("space units"), header);
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
        std::uint64_t count = 0;
        const auto [stop, problem] = std::from_chars(sizes[i].data(), sizes[i].data() + sizes[i].size(), count);
        if (!step || axes == 3 || problem != std::errc() || stop != sizes[i].data() + sizes[i].size()) {
            header.refuse("its sizes or space directions are not those of an image of three dimensions");
        }
        if (i < axis_units.size() && field("space units").empty() && mm_of(axis_units[i], header) != 1) {
            header.refuse("its units state " + printable(std::string(axis_units[i])) +
                          ", but hold for no axis with a space direction; state 'space units'");
        }
        size[axes] = count;
        steps[axes++] = in_lps(*step);
    }
    if (axes != 3) {
        header.refuse("an image of " + std::to_string(axes) + " dimensions, not of 3");
    }
    return upright(header.name, size, steps, in_lps(*origin));
}

}  // namespace lamella
