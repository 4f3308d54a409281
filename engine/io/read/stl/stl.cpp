// STL, binary and ASCII. Which of the two a file is, is decided by its size and content, never by the word "solid" alone.

#include "base/words.hpp"
#include "io/read/stl/stl_ascii.hpp"

namespace lamella {

namespace {

// A binary file: 80 bytes of anything, the number of triangles, and for each 12 floats (normal, three vertices) and 16 bits.
//
//     | header 80 | count 4 | normal 12 | vertices 36 | attribute 2 | normal ...
//     0           80        84          96            132           134
constexpr std::size_t header_bytes = 84;
constexpr std::size_t record_bytes = 50;
constexpr std::size_t normal_bytes = 12;

bool begins_with_solid(std::string_view text) {
    text = without_byte_order_mark(text);
    text.remove_prefix(static_cast<std::size_t>(skip_space(text.begin(), text.end()) - text.begin()));
    return begins_in_any_case(text, "solid");
}

std::uint32_t counted_triangles(std::string_view sample) {
    std::uint32_t count = 0;
    std::memcpy(&count, sample.data() + 80, sizeof count);
    return count;
}

/// The number of triangles, if the file holds as many as it says.
Result<std::uint64_t> check_binary(const FileSource& file) {
    if (file.size() < header_bytes) {
        return file.error(ErrorCode::malformed_mesh,
                          "is no STL file: " + counted(file.size(), "byte") + ", and a binary header alone has 84", 0);
    }
    const std::uint64_t count = counted_triangles(file.sample());
    const std::uint64_t needed = header_bytes + record_bytes * count;
    if (count == 0 && file.size() == header_bytes) {
        return file.error(ErrorCode::empty_mesh, "holds no triangles");
    }
    if (count == 0) {
        return file.error(ErrorCode::malformed_mesh,
                          "counts 0 triangles at byte 80, but " + counted(file.size() - needed, "byte") +
                              (file.size() - needed == 1 ? " follows" : " follow"),
                          80);
    }
    if (needed > file.size()) {
        return file.error(ErrorCode::malformed_mesh,
                          "is truncated or no STL file: counts " + counted(count, "triangle") + " at byte 80, which " +
                              (count == 1 ? "takes " : "take ") + std::to_string(needed) + " bytes, but has " +
                              std::to_string(file.size()),
                          80);
    }
    return count;
}

/// True if what is no text would be, were it not for NUL bytes, and holds a facet.
bool is_ascii_with_nuls(const FileSource& file) {
    const std::string_view sample = file.sample();
    if (!begins_with_solid(sample) || check_binary(file)) {
        return false;
    }
    const bool others = std::any_of(sample.begin(), sample.end(), [](char c) { return c > 0 && c < ' ' && !is_space(c); });
    constexpr std::string_view facet = "facet";
    return !others && std::search(sample.begin(), sample.end(), facet.begin(), facet.end(),
                                  [](char a, char b) { return lower_case(a) == b; }) != sample.end();
}

/// True if NUL bytes in [begin, end) of `text` stand between words.
bool are_between_words(std::string_view text, std::size_t begin, std::size_t end) {
    return (begin == 0 || is_space(text[begin - 1])) && (end == text.size() || is_space(text[end]));
}

/// Writes spaces over the NUL bytes, and says so in a warning. An error where they are within words other than those of a
/// name, as what they replace is then unknown.
void blank_nuls(FileContents& file, std::vector<std::string>& warnings) {
    const std::string_view text = file.whole;
    const char* const text_end = text.data() + text.size();
    Lookout lookout(file.source.parallel());
    std::size_t count = 0;
    std::size_t line_end = 0;
    const char* word = nullptr;  // the line's first, or white space before it
    const std::size_t first = text.find('\0');
    for (std::size_t begin = first; begin != std::string_view::npos; begin = text.find('\0', begin)) {
        const std::size_t end = std::min(text.find_first_not_of('\0', begin), text.size());
        lookout.pass();
        if (begin >= line_end) {
            word = text.data() + (text.find_last_of("\r\n", begin) + 1);  // 0 where there is no line before
            line_end = std::min(text.find_first_of("\r\n", begin), text.size());
        }
        word = skip_space(word, text_end);
        const bool is_name = is_word<"solid">(word, text_end) || is_word<"endsolid">(word, text_end);
        if (!is_name && !are_between_words(text, begin, end)) {
            throw TextError{text.data() + begin, "a NUL byte within a word of an ASCII STL file: what stood there is lost"};
        }
        std::fill_n(file.bytes.data() + begin, end - begin, std::byte{' '});
        count += end - begin;
    }
    warnings.push_back(file.source.name() + ": is an ASCII STL file with " + counted(count, "NUL byte") +
                       ", read as spaces, the first in line " + std::to_string(line_of(text, first)));
}

void warn_of_departures(const FileContents& file, const AsciiFacets& facets, std::vector<std::string>& warnings) {
    const std::string& name = file.source.name();
    if (const LeftOut& odd = facets.departures.facets; odd.count > 0) {
        warnings.push_back(name + ": read " + counted(odd.count, "facet") + " by the vertices alone" +
                           first_line_words(odd, file.whole) + ": " + facets.departures.first_facet);
    }
    if (const LeftOut& lines = facets.departures.lines; lines.count > 0) {
        warnings.push_back(name + ": ignored " + counted(lines.count, "line") + " between facets" +
                           first_word_words(lines, file.whole));
    }
    if (facets.open_end != nullptr) {
        const std::size_t line = line_of(file.text, static_cast<std::size_t>(facets.open_end - file.text.data()));
        warnings.push_back(name + ": ends without 'endsolid' after line " + std::to_string(line) +
                           ": what follows may have been cut off");
    }
}

/// Beyond the sample, NUL bytes are looked for only where something is wrong.
AsciiFacets facets_of(FileContents& file, std::vector<std::string>& warnings) {
    const FileSource& source = file.source;
    if (!is_text(source.sample())) {
        blank_nuls(file, warnings);
    }
    try {
        return parse_ascii_stl(file.text, source.memory(), source.parallel());
    } catch (const TextError&) {
        if (file.text.find('\0') == std::string_view::npos) {
            throw;
        }
    }
    blank_nuls(file, warnings);
    return parse_ascii_stl(file.text, source.memory(), source.parallel());
}

void parse_ascii(FileContents& file, MeshFile& mesh) {
    AsciiFacets facets = facets_of(file, mesh.warnings);
    if (const LeftOut& lines = facets.departures.lines; facets.count == 0 && lines.count > 0) {
        throw TextError{lines.first, "expected 'facet', 'solid' or 'endsolid', found " +
                                         word_at(lines.first, file.whole.data() + file.whole.size())};
    }
    if (facets.count == 0) {
        file.source.refuse(ErrorCode::empty_mesh, "holds no triangles");
    }
    mesh.bytes = std::move(facets.coordinates);
    mesh.stride = 9 * sizeof(float);
    mesh.triangle_count = facets.count;
    mesh.text = true;
    give_parts(facets.solids, false, file.source.name(), mesh);
    give_stated_frame(file.text.substr(0, file.text.find_first_of("\r\n")), file.source, mesh);
    warn_of_departures(file, facets, mesh.warnings);
}

}  // namespace

bool looks_like_stl(const FileSource& source) {
    return is_text(source.sample()) ? begins_with_solid(source.sample())
                                    : check_binary(source).ok() || is_ascii_with_nuls(source);
}

MeshFile read_stl(FileSource& source) {
    if (is_text(source.sample()) || is_ascii_with_nuls(source)) {
        return read_contents(source, parse_ascii);
    }
    MeshFile mesh = describe_binary_stl(source);
    mesh.bytes = source.take(header_bytes + record_bytes * mesh.triangle_count);
    return mesh;
}

bool is_binary_stl(const FileSource& source) {
    return !is_text(source.sample()) && check_binary(source).ok();
}

MeshFile describe_binary_stl(const FileSource& file) {
    const std::uint64_t count = require(check_binary(file));
    const std::uint64_t needed = header_bytes + record_bytes * count;
    MeshFile mesh;
    mesh.first_offset = header_bytes + normal_bytes;
    mesh.stride = record_bytes;
    mesh.triangle_count = count;
    give_stated_frame(file.sample().substr(0, 80), file, mesh);
    if (file.size() > needed) {
        mesh.warnings.push_back(file.name() + ": ignored " + counted(file.size() - needed, "byte") + " after the last of " +
                                counted(count, "triangle"));
    }
    return mesh;
}

}  // namespace lamella
