#include <limits>
#include <string>

#include "engine/shapes.hpp"
#include "ply_writer.hpp"
#include "read.hpp"

namespace lamella::ply_test {

using namespace input_test;

using Catch::Contains;

namespace {

const std::vector<double> corners = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
const Faces tetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

/// An ASCII header with four vertices and `faces` faces.
std::string header_of(const std::string& format, const std::string& vertex_count, const std::string& face_count,
                      const std::string& count_type = "uchar", const std::string& index_type = "int") {
    return "ply\nformat " + format + " 1.0\nelement vertex " + vertex_count +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + face_count + "\nproperty list " +
           count_type + " " + index_type + " vertex_indices\nend_header\n";
}

const std::string four_vertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

Error malformed(const std::string& bytes, const std::string& says = "", const std::string& says_too = "") {
    const Error error = refuses(dir.write("a.ply", bytes), says, says_too);
    CHECK(error.code == ErrorCode::malformed_mesh);
    CHECK(error.message.size() < 400);
    return error;
}

/// `bytes` after the header of a binary file whose one face is `face`.
std::string binary_tetrahedron(std::string_view encoding, std::string_view count_type, std::string_view index_type,
                               double count, const std::vector<double>& face) {
    PlyWriter out(encoding);
    detail::add_vertices(out, {}, corners);
    out.header("element face 1")
        .header("property list " + std::string(count_type) + " " + std::string(index_type) + " vertex_indices");
    out.number(count_type, count);
    for (const double index : face) {
        out.number(index_type, index);
    }
    return out.file();
}

}  // namespace

TEST_CASE("a PLY file cut off anywhere is refused", "[input][ply]") {
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    how.faces_first = GENERATE(false, true);
    how.extra_elements = GENERATE(false, true);
    how.extra_lists = how.extra_elements;
    const std::string bytes = ply(how, corners, tetrahedron);
    const std::size_t needed = bytes.size() - (how.encoding == "ascii" ? 2 : 1);  // the last word may lose its line end
    // What is left of the last number may be a number, too.
    refuses_cuts("a.ply", bytes, 4, how.encoding == "ascii" && bytes[needed - 1] != ' ' ? needed : needed + 1);
}

TEST_CASE("malformed PLY headers are refused with line and byte", "[input][ply]") {
    const auto [from, to, message] = GENERATE(table<std::string, std::string, std::string>({
        {"ply\n", "ply x\n", "line 1, byte 4: expected 'ply' alone on the first line, found 'x'"},
        {"format ascii 1.0\n", "", "line 8, byte 126: expected a line 'format' before it, found 'end_header'"},
        {"ascii", "utf8", "line 2, byte 11: expected 'ascii', 'binary_little_endian' or 'binary_big_endian', found 'utf8'"},
        {"ascii", "ASCII", "found 'ASCII'"},
        {"ascii 1.0", "ascii 2.0", "line 2, byte 17: expected version '1.0', found '2.0'"},
        {"ascii 1.0", "ascii", "line 2, byte 16: expected version '1.0', found the end of the line"},
        {"ascii 1.0", "ascii 1.0 x", "expected the end of the line, found 'x'"},
        {"format", "format ascii 1.0\nformat", "line 3, byte 21: expected one format only"},
        {"element vertex", "elements vertex",
         "line 3, byte 21: expected 'element', 'property', 'comment' or 'end_header', "},
        {"vertex 4", "vertex", "expected the number of elements 'vertex', found the end of the line"},
        {"vertex 4", "vertex -4", "expected the number of elements 'vertex', found '-4'"},
        {"vertex 4", "vertex 4.0", "found '4.0'"},
        {"vertex 4", "vertex 99999999999999999999", "found '99999999999999999999'"},
        {"vertex 4", "", "expected a name, found the end of the line"},
        {"float x", "float", "line 4, byte 52: expected a name, found the end of the line"},
        {"property float z", "float z", "expected 'element', 'property', 'comment' or 'end_header', found 'float'"},
        {"property list", "list", "expected 'element', 'property', 'comment' or 'end_header', found 'list'"},
        {"float x", "real x", "line 4, byte 47: expected a type of number, found 'real'"},
        {"float x", "float w", "line 3, byte 21: element 'vertex' has no property 'x'"},
        {"float y", "float x", "line 3, byte 21: property 'x' of element 'vertex' is declared twice"},
        {"property float z\n", "", "element 'vertex' has no property 'z'"},
        {"float z", "list uchar float z", "property 'z' of element 'vertex' is a list"},
        {"vertex_indices", "vertices", "line 7, byte 89: element 'face' has no property 'vertex_indices'"},
        {"list uchar int vertex", "int vertex", "property 'vertex_indices' of element 'face' is no list"},
        {"uchar int", "uchar", "expected a type of number, found 'vertex_indices'"},
        {"element face", "element vertex 1\nelement face", "element 'vertex' is declared twice"},
        {"element vertex", "property int x\nelement vertex", "line 3, byte 21: expected an element before its properties"},
        {"end_header\n", "", "expected 'element', 'property', 'comment' or 'end_header', found '0'"},
        {"end_header", "end_header x", "expected the end of the line, found 'x'"},
        {"element vertex 4", "element vertex 0", ": holds faces but no vertices"},
    }));
    std::string text = header_of("ascii", "4", "1") + four_vertices + "3 0 1 2\n";
    text.replace(text.find(from), from.size(), to);
    malformed(text, message);
}

TEST_CASE("lines of a PLY header without a keyword are skipped with a warning", "[input][ply]") {
    const auto warnings = [&](const std::string& lines, const std::string& before) {
        std::string text = header_of("ascii", "4", "1") + four_vertices + "3 0 1 2\n";
        text.insert(text.find(before), lines);
        const auto path = dir.write("a.ply", text);
        CHECK(read_one(path).triangle_count == 1);
        return warnings_of(path).at(0);
    };
    CHECK(warnings("made by hand\n", "element vertex") ==
          "ignored 1 line of the header without a keyword, the first in line 3: 'made'");
    CHECK(warnings("comment a\nb c\nd\n", "element face") ==
          "ignored 2 lines of the header without a keyword, the first in line 8: 'b'");
    CHECK(warnings("float quality\n", "element face") ==
          "ignored 1 line of the header without a keyword, the first in line 7: 'float'");

    std::string binary = header_of("binary_little_endian", "3", "1");
    binary.insert(binary.find("element face"), "made by hand\n");
    const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::uint32_t corners[3] = {0, 1, 2};
    binary.append(reinterpret_cast<const char*>(vertices), sizeof vertices) += '\3';
    binary.append(reinterpret_cast<const char*>(corners), sizeof corners);
    CHECK(read_mesh(dir.write("b.ply", binary))->warnings.size() == 1);
    // A property's numbers would be taken for others.
    binary.replace(binary.find("made by hand"), 12, "float red   ");
    malformed(binary, "line 7, byte ", "expected 'element', 'property', 'comment' or 'end_header', found 'float'");
}

TEST_CASE("words after the declared properties of a PLY row are ignored with a warning", "[input][ply]") {
    const std::string rows = "0 0 0 9\n1 0 0 9 8\n1 1 0\n0 1 0 7 # a\n3 0 1 2 255 0 0\n";
    const auto path = dir.write("a.ply", header_of("ascii", "4", "1") + rows);
    CHECK(read_one(path).triangle_count == 1);
    CHECK(warnings_of(path) == Texts{"ignored what follows the declared properties in 4 lines, "
                                     "the first in line 10"});
    // From number to number this is a mesh too, with its first face in the place of a vertex.
    const std::string alike = "0 0 0 3\n1 0 0 0\n1 1 0 1\n0 1 0 2\n3 0 1 2\n";
    CHECK(read_mesh(dir.write("b.ply", header_of("ascii", "4", "1") + alike))->warnings.size() == 1);
}

TEST_CASE("a PLY header without end is refused", "[input][ply]") {
    const std::string header = header_of("binary_little_endian", "4", "1");
    malformed(header.substr(0, header.find("end_header")), "expected 'end_header', found the end of the file");
    std::string endless = "ply\nformat ascii 1.0\nelement vertex 1\n";
    for (int i = 0; i < 5000; ++i) {
        endless += "property float p" + std::to_string(i) + "\n";
    }
    malformed(endless, "expected at most 4096 elements and properties");
}

TEST_CASE("PLY without faces holds no mesh", "[input][ply]") {
    const std::string points = header_of("ascii", "4", "0") + four_vertices;
    CHECK(read_error(dir.write("a.ply", points)).code == ErrorCode::empty_mesh);
    const std::string no_face = "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nend_header\n0\n";
    CHECK(read_error(dir.write("a.ply", "ply\nformat ascii 1.0\nend_header\n")).code == ErrorCode::empty_mesh);
    CHECK(read_error(dir.write("a.ply", no_face)).code == ErrorCode::malformed_mesh);
}

TEST_CASE("PLY counts beyond the bytes that are left are refused", "[input][ply]") {
    const std::string format = std::string(GENERATE(from_range(ply_encodings)));
    const std::string count = GENERATE(as<std::string>(), "5000", "4294967296", "1537228672809129302", "9223372036854775807",
                                       "18446744073709551615");
    const std::string body(100, '0');
    malformed(header_of(format, count, "1") + body,
              "the header counts " + count + " of element 'vertex', but 100 bytes are left");
    malformed(header_of(format, "0", count) + body, "holds faces but no vertices");
    const std::string one_vertex = format == "ascii" ? "0 0 0\n" : std::string(12, '\0');
    malformed(header_of(format, "1", count) + one_vertex + body,
              "the header counts " + count + " of element 'face', but 10");
}

TEST_CASE("PLY elements that take no bytes are skipped, however many", "[input][ply]") {
    const std::string format = std::string(GENERATE(from_range(ply_encodings)));
    PlyVariant how;
    how.encoding = format;
    std::string bytes = ply(how, corners, tetrahedron);
    bytes.insert(bytes.find("element face"), "element nothing 18446744073709551615\n");
    CHECK(read_one(dir.write("a.ply", bytes)).triangle_count == 4);
}

TEST_CASE("PLY lists with a wrong length are refused", "[input][ply]") {
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const std::size_t header = binary_tetrahedron(encoding, "int", "int", 3, {0, 1, 2}).find("end_header\n") + 11;
    const std::size_t face = header + (encoding == "ascii" ? four_vertices.size() : 48);
    for (const double count : {4.0, 5.0, 100000.0, 2147483647.0}) {
        const std::string bytes = binary_tetrahedron(encoding, "int", "int", count, {0, 1, 2});
        const Error error = malformed(bytes, "property 'vertex_indices' of 'face' 0: ");
        CHECK(error.byte_offset >= static_cast<std::int64_t>(face));
    }
    for (const double count : {-1.0, -3.0, -2147483648.0}) {
        const std::string bytes = binary_tetrahedron(encoding, "int", "int", count, {0, 1, 2});
        const Error error = malformed(bytes, "a list of " + std::to_string(static_cast<long>(count)) + " numbers");
        CHECK(error.byte_offset == static_cast<std::int64_t>(face));
    }
    const auto infinity = std::numeric_limits<double>::infinity();
    const double bad = GENERATE_COPY(2.5, infinity, std::numeric_limits<double>::quiet_NaN(), 1e300);
    if (encoding != "ascii") {
        const std::string bytes = binary_tetrahedron(encoding, "double", "int", bad, {0, 1, 2});
        malformed(bytes, "expected the length of a list, found ");
    }
}

TEST_CASE("PLY indices out of range are refused", "[input][ply]") {
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const std::size_t corner = GENERATE(range<std::size_t>(0, 4));
    const bool quad = GENERATE(false, true);
    const double index = GENERATE(4.0, -1.0, 2147483647.0, -2147483648.0);
    if (corner == 3 && !quad) {
        return;
    }
    std::vector<double> face = {0, 1, 3, 2};
    face.resize(quad ? 4 : 3);
    face[corner] = index;
    const std::string bytes = binary_tetrahedron(encoding, "uchar", "int", static_cast<double>(face.size()), face);
    const std::string number = std::to_string(static_cast<long>(index));
    const Error error =
        malformed(bytes, "property 'vertex_indices' of 'face' 0: index " + number, number + ", but there are 4 vertices");
    const auto offset = static_cast<std::size_t>(error.byte_offset);
    if (encoding == "ascii") {
        CHECK_THAT(error.message, Contains(": line 14, byte " + std::to_string(offset)));
        CHECK(bytes.compare(offset, 1, number, 0, 1) == 0);
    } else {
        CHECK(offset == bytes.size() - 4 * (face.size() - corner));
    }
}

TEST_CASE("malformed words of ASCII PLY are refused with line and byte", "[input][ply]") {
    const std::string word = GENERATE(as<std::string>(), "nan", "inf", "-inf", "1e400", "1,5", "1.5f", "--1", "+", ".",
                                      "0x10", "abc", std::string(5000, '9'));
    const std::string header = header_of("ascii", "4", "1");
    const auto refused_at = [&](const std::string& body, std::size_t at, const std::string& line, const std::string& says) {
        CHECK(malformed(header + body, line, says).byte_offset == static_cast<std::int64_t>(header.size() + at));
    };
    refused_at("0 0 0\n1 " + word + " 0\n0 1 0\n0 0 1\n3 0 1 2\n", 8, ": line 11, byte ",
               "property 'y' of 'vertex' 1: expected a finite ");
    refused_at(four_vertices + "3 0 1 " + word + "\n", four_vertices.size() + 6, ": line 14, byte ",
               "property 'vertex_indices' of 'face' 0: expected an ");
    refused_at(four_vertices + word + " 0 1 2\n", four_vertices.size(), ": line 14, byte ",
               "expected the length of a list, found '" + word.substr(0, 32));
}

TEST_CASE("the first error of an ASCII PLY file is reported on any number of threads", "[input][ply]") {
    const shapes::Indexed sphere = shapes::indexed(shapes::octasphere({1, 2, 3}, 20, 7));  // of several pieces
    std::string text = ply({}, sphere);
    for (const std::size_t from : {text.size() - 1000, text.size() / 5 * 4, text.size() / 2, text.size() / 5}) {
        const std::size_t line = text.rfind('\n', from) + 1;
        text[line] = 'x';
        CHECK(malformed(text).byte_offset == static_cast<std::int64_t>(line));
    }
}

TEST_CASE("PLY that expands to more than reading may take is refused", "[input][ply]") {
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    PlyVariant how;
    how.encoding = encoding;
    how.index = "uchar";
    const std::string bytes = ply(how, corners, Faces(10, std::vector<double>(200, 1)));
    const auto path = dir.write("a.ply", bytes);
    CHECK_THAT(message_beyond(20'000, path),
               Contains(path.string() + ": expands to ") && Contains("more than the 20000 bytes that reading"));
}

TEST_CASE("PLY polygons with a corner that is not finite are refused", "[input][ply]") {
    PlyVariant how;
    how.encoding = GENERATE(as<std::string_view>(), "binary_little_endian", "binary_big_endian");
    std::vector<double> xyz = corners;
    xyz[7] = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
    malformed(ply(how, xyz, {{0, 1, 3}, {0, 1, 2, 3}}), "'face' 1: vertex 2 has a coordinate that is not finite");
}

}  // namespace lamella::ply_test
