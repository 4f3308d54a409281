// Triangle surfaces of FreeSurfer, big-endian throughout:
//
//     | FF FF FE | text, one newline or two | points n 4 | triangles m 4 | coordinates 12 n | corners 12 m | footer
//
// The footer is absent, or begins with tags (2, whether the points are in the scanner's frame) and (20, lines of text):
// which volume the surface was made of, and where in the scanner it lay.
#include "base/words.hpp"
#include "io/read/arrays/array_file.hpp"

namespace lamella {

namespace {

constexpr std::string_view triangles_magic = "\xFF\xFF\xFE";
constexpr std::string_view quads_magic = "\xFF\xFF\xFD";
constexpr std::string_view other_magic = "\xFF\xFF\xFF";  // old quads, or numbers at vertices
constexpr std::uint64_t row_bytes = 12;                   // of a point, and of a triangle

/// A number at `offset`, where there is one; 0 where not.
std::uint32_t surface_word(std::string_view text, std::size_t offset) {
    return offset + 4 <= text.size() ? load_number<std::uint32_t>(text.data() + offset, true) : 0;
}

/// The bytes that the two counts at the begin of `text` take, and they; 0: they do not fit into it.
std::uint64_t surface_bytes(std::string_view text) {
    const std::uint64_t bytes = 8 + row_bytes * (std::uint64_t{surface_word(text, 0)} + surface_word(text, 4));
    return bytes <= text.size() ? bytes : 0;
}

/// From the counts on. Text of some programs ends with one newline, which a second may follow, or a count that looks like
/// one.
std::string_view after_text(const ArrayFile& file) {
    const std::size_t newline = file.text.find('\n');
    if (newline == std::string_view::npos) {
        throw TextError{file.text.data(), "is truncated within the text of a FreeSurfer surface", false};
    }
    const std::string_view one = file.text.substr(newline + 1);
    const std::string_view two = one.substr(one.starts_with('\n') ? 1 : 0);
    const std::string_view rest = surface_bytes(two) > 8 || surface_bytes(one) <= 8 ? two : one;
    if (surface_bytes(rest) == 0) {
        throw TextError{rest.data(),
                        "is truncated: counts " + counted(surface_word(rest, 0), "point") + " and " +
                            counted(surface_word(rest, 4), "triangle") + " at 12 bytes each, but has " +
                            counted(rest.size(), "byte"),
                        false};
    }
    return rest;
}

/// Says where the points are, of what follows the triangles.
void read_footer(std::string_view footer, const FileSource& source, MeshFile& mesh) {
    constexpr std::uint32_t frame_tag = 2;
    constexpr std::uint32_t volume_tag = 20;
    if (surface_word(footer, 0) == frame_tag && surface_word(footer, 4) == 1) {
        mesh.patient_frame = PatientFrame::ras;
    } else if (const std::size_t line = footer.find("\ncras"); line != std::string_view::npos) {
        const std::string_view centre = footer.substr(line + 6, footer.find('\n', line + 6) - line - 6);
        const auto numbers = parse_numbers(trimmed(centre, " ="), ' ');
        if (footer.find("valid = 1") != std::string_view::npos && numbers != std::vector<double>{0, 0, 0}) {
            mesh.warnings.push_back(source.name() +
                                    ": points are as stored, in the surface's own frame, whose centre is at " +
                                    in_quotes(trimmed(centre, " =")) + " of the scanner's");
        }
    } else if (!footer.empty() && surface_word(footer, 0) != frame_tag && surface_word(footer, 0) != volume_tag) {
        mesh.warnings.push_back(source.name() + ": ignored " + counted(footer.size(), "byte") + " after the last triangle");
    }
}

}  // namespace

bool looks_like_freesurfer(const FileSource& source) {
    const std::string_view sample = source.sample();
    return sample.starts_with(triangles_magic) ||
           ((sample.starts_with(quads_magic) || sample.starts_with(other_magic)) && !is_binary_stl(source));
}

void parse_freesurfer(FileContents& contents, MeshFile& mesh) {
    ArrayFile file(contents);
    if (!file.text.starts_with(triangles_magic)) {
        throw TextError{file.text.data(), "is a FreeSurfer file of quads, or of numbers at points, not of triangles", false};
    }
    const std::string_view rest = after_text(file);
    const std::uint32_t point_count = surface_word(rest, 0);
    const std::uint32_t triangle_count = surface_word(rest, 4);
    const auto array = [&](std::uint64_t first, std::uint64_t rows, NumberType type) {
        const char* const at = rest.data() + first;
        return NumberArray{reinterpret_cast<const std::byte*>(at), 3 * rows, type, true, NumberArray::Form::bytes, at};
    };
    NumberArray points = array(8, point_count, NumberType::float32);
    CellArray triangles{.name = "triangles", .cells = triangle_count, .point_count = point_count};
    triangles.corners = array(8 + row_bytes * point_count, triangle_count, NumberType::int32);
    give_points(file, {&points, 1}, mesh);
    cut_cells(file, {&triangles, 1}, mesh);
    read_footer(rest.substr(surface_bytes(rest)), file.source, mesh);
}

}  // namespace lamella
