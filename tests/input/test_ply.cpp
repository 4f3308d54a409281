#include <algorithm>
#include <limits>
#include <string>

#include "engine/shapes.hpp"
#include "ply_writer.hpp"
#include "read.hpp"

namespace lamella::ply_test {

using namespace input_test;
using Catch::Contains;

namespace {

const shapes::Indexed& cube() {
    static const shapes::Indexed mesh = shapes::indexed(shapes::box({1, 2, 3}, {21, 22, 23}));
    return mesh;
}

const std::vector<double> corners = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
const Faces tetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

Contents read_ply(const std::string& bytes) {
    return read(dir.write("a.ply", bytes));
}

Triangles triangles_in(const shapes::Indexed& mesh) {
    Triangles triangles(mesh.indices.size() / 3);
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
        std::copy_n(mesh.xyz.begin() + 3 * mesh.indices[i], 3, triangles[i / 3].begin() + 3 * (i % 3));
    }
    return triangles;
}

Error malformed(const std::string& bytes, const std::string& says) {
    return refuses(dir.write("a.ply", bytes), says);
}

/// Four vertices and one face, whose list says that it has `count` numbers.
std::string one_face(std::string_view encoding, std::string_view count_type, double count, const std::vector<double>& face) {
    PlyWriter out(encoding);
    PlyVariant().vertices(out, corners);
    out.header("element face 1").header("property list " + std::string(count_type) + " int vertex_indices");
    out.number(count_type, count);
    for (const double index : face) {
        out.number("int", index);
    }
    return out.file();
}

}  // namespace

TEST_CASE("PLY of every encoding and type of number gives the same mesh", "[input][ply]") {
    constexpr const char* types[2][8] = {{"char", "uchar", "short", "ushort", "int", "uint", "float", "double"},
                                         {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"}};
    const Triangles expected = triangles_in(cube());
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const std::size_t coordinate = GENERATE(range<std::size_t>(0, 8));
    for (std::size_t count = 0; count < 8; ++count) {
        for (std::size_t index = 0; index < 8; ++index) {
            const PlyVariant how{encoding, types[count % 2][coordinate], types[index % 2][count], types[count % 2][index]};
            CAPTURE(how.encoding, how.coordinate, how.count, how.index);
            CHECK(read_ply(ply(how, cube())).triangles == expected);
        }
    }
}

TEST_CASE("PLY elements and properties in any order, with unknown ones between, give the same mesh", "[input][ply]") {
    const Triangles expected = triangles_in(cube());
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    how.coordinate = GENERATE(as<std::string_view>(), "float", "double", "short");
    how.faces_first = GENERATE(false, true);
    how.index_name = how.faces_first ? "vertex_index" : "vertex_indices";
    for (int extras = 0; extras < 8; ++extras) {
        how.extra_numbers = (extras & 1) != 0;
        how.extra_lists = (extras & 2) != 0;
        how.extra_elements = (extras & 4) != 0;
        how.axes = {0, 1, 2};
        do {
            CAPTURE(how.encoding, how.coordinate, how.faces_first, extras, how.axes);
            CHECK(read_ply(ply(how, cube())).triangles == expected);
        } while (std::next_permutation(how.axes.begin(), how.axes.end()));
    }
}

TEST_CASE("PLY coordinates keep their precision", "[input][ply]") {
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    for (const auto& [type, x] : {std::pair("double", 0.1 + 0x1p-40),
                                  {"int", -2147483648.0},
                                  {"int", 16777217},
                                  {"uint", 4294967295.0},
                                  {"float", -0.375},
                                  {"short", -32768},
                                  {"ushort", 65535},
                                  {"char", -128},
                                  {"uchar", 255}}) {
        const PlyVariant how{encoding, type};
        const Contents contents = read_ply(ply(how, {x, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}}));
        const bool wide = how.coordinate == "double" || how.coordinate == "int" || how.coordinate == "uint";
        CHECK((contents.mesh.vertex_type == Number::f64) == wide);
        CHECK(contents.mesh.text == (encoding == "ascii"));
        const double written = encoding == "ascii" && x < 1 && x > 0 ? 0.1 : x;  // six decimals
        CHECK(contents.triangles[0][0] == written);
    }
}

TEST_CASE("PLY floats of the machine's own byte order stay where they lie", "[input][ply]") {
    PlyVariant how{"binary_little_endian"};
    how.faces_first = GENERATE(false, true);
    how.coordinate = GENERATE(as<std::string_view>(), "float", "double");
    const std::string bytes = ply(how, cube());
    const MeshFile mesh = read_one(dir.write("a.ply", bytes));
    CHECK(mesh.bytes.size() == bytes.size());
    CHECK(mesh.first_offset + mesh.vertex_count * mesh.stride <= bytes.size());
    how.axes = {0, 2, 1};
    CHECK(read_one(dir.write("a.ply", ply(how, cube()))).first_offset == 0);
}

TEST_CASE("PLY polygons are cut into triangles, and faces of fewer than three vertices left out", "[input][ply]") {
    PlyVariant how{GENERATE(from_range(ply_encodings))};
    how.faces_first = GENERATE(false, true);
    // A prism over an L of six corners, concave at the last one, 2 high.
    const std::vector<double> xyz = {0, 0, 0, 3, 0, 0, 3, 1, 0, 1, 1, 0, 1, 3, 0, 0, 3, 0,
                                     0, 0, 2, 3, 0, 2, 3, 1, 2, 1, 1, 2, 1, 3, 2, 0, 3, 2};
    const Faces faces = {
        {5, 4, 3, 2, 1, 0}, {6, 7, 8, 9, 10, 11}, {},     {0},          {0, 1, 7, 6}, {1, 2, 8, 7}, {2, 3, 9, 8},
        {3, 4, 10, 9},      {4, 5, 11, 10},       {0, 1}, {5, 0, 6, 11}};
    const Contents contents = read_ply(ply(how, xyz, faces));
    CHECK(contents.triangles.size() == 2 * 4 + 6 * 2);
    CHECK(volume_of(contents.triangles) == Approx(10));
    CHECK(contents.warnings == Texts{"left out 3 faces of fewer than three vertices"});
}

TEST_CASE("PLY triangle strips alternate and begin again after -1", "[input][ply]") {
    PlyWriter out(GENERATE(from_range(ply_encodings)));
    const bool strips_first = GENERATE(false, true);
    const std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
    if (!strips_first) {
        PlyVariant().vertices(out, xyz);
    }
    out.header("element tristrips 2").header("property list int int vertex_indices");
    out.list("int", "int", {0, 1, 2, 3, 4, -1, 2, 1, 0, -1, -1, 0, 1, 4, -1, 0, 1, -1}).end_row();
    out.list("int", "int", {0, 1, 1, 2, 3}).end_row();
    if (strips_first) {
        PlyVariant().vertices(out, xyz);
    }
    const MeshFile mesh = read_one(dir.write("a.ply", out.file()));
    const std::vector<std::uint32_t> indices(mesh.indices.begin(), mesh.indices.end());
    CHECK(indices == std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3, 2, 3, 4, 2, 1, 0, 0, 1, 4, 1, 2, 3});
}

TEST_CASE("binary PLY is read behind a header of any line ends, and before a tail", "[input][ply]") {
    PlyVariant how{GENERATE(as<std::string_view>(), "binary_little_endian", "binary_big_endian"), "int"};
    // The first byte of the data is one that ends lines: it is data.
    std::vector<double> xyz = cube().xyz;
    xyz[0] = how.encoding == "binary_big_endian" ? 0x0A000000 : 0x0A;
    const std::string bytes = ply(how, xyz, faces_of(cube()));
    const std::size_t body = bytes.find("end_header\n") + 11;
    const Triangles expected = triangles_in({xyz, cube().indices});
    for (const auto& [what, by] : {std::pair("\n", "\r\n"),
                                   {"\n", "\r"},
                                   {"\n", " \t\n"},
                                   {" ", " \t "},
                                   {"property", "\tproperty"},
                                   {"\nproperty", "\n\n \nproperty"}}) {
        CHECK(read_ply(replaced(bytes.substr(0, body), what, by) + bytes.substr(body)).triangles == expected);
    }
    const Contents with_tail = read_ply(bytes + "tail");
    CHECK(with_tail.triangles == expected);
    CHECK(with_tail.warnings == Texts{"ignored 4 bytes after the last element"});
    const std::string noted = replaced(bytes, "element face", "made by hand\nelement face");
    CHECK(read_ply(noted).warnings == Texts{"ignored 1 line of the header without a keyword, the first in line 7: 'made'"});
    // A property's numbers would be taken for others.
    malformed(replaced(noted, "made by hand", "float red   "),
              "line 7, byte ... expected 'element', 'property', 'comment' or 'end_header', found 'float'");
}

TEST_CASE("text PLY parsed in many pieces gives every face once, in order", "[input][ply][threads]") {
    const shapes::Indexed sphere = shapes::indexed(shapes::octasphere({1, 2, 3}, 20, 7));  // 5 MB
    Faces faces = faces_of(sphere);
    // Fewer triangles in a piece than its lines and words let expect. Without such: tests/golden.
    std::size_t small = 0;
    for (std::size_t at = 20; at < 120'000; at += 30'000) {
        faces.insert(faces.begin() + static_cast<std::ptrdiff_t>(at), {{0}, {1, 2}});
        small += 2;
    }
    PlyVariant how;
    how.faces_first = true;
    how.extra_elements = true;
    const std::string by_lines = ply(how, sphere.xyz, faces);
    const Contents contents = read_ply(by_lines);
    CHECK(contents.triangles.size() == faces.size() - small);
    CHECK(std::equal(contents.mesh.indices.begin(), contents.mesh.indices.end(), sphere.indices.begin(),
                     sphere.indices.end()));
    CHECK(contents.warnings.size() == 1);
    const std::size_t body = by_lines.find("end_header\n") + 11;
    CHECK((read_ply(by_lines.substr(0, body) + "\n" + by_lines.substr(body)).triangles == contents.triangles));
}

TEST_CASE("a PLY file cut off anywhere is refused", "[input][ply]") {
    PlyVariant how{GENERATE(from_range(ply_encodings))};
    how.faces_first = GENERATE(false, true);
    how.extra_elements = GENERATE(false, true);
    how.extra_lists = how.extra_elements;
    const std::string bytes = ply(how, corners, tetrahedron);
    const std::size_t needed = bytes.size() - (how.encoding == "ascii" ? 2 : 1);  // the last word may lose its line end
    // What is left of the last number may be a number, too.
    refuses_cuts("a.ply", bytes, 4, how.encoding == "ascii" && bytes[needed - 1] != ' ' ? needed : needed + 1);
}

TEST_CASE("PLY counts beyond the bytes that are left are refused", "[input][ply]") {
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const std::string count = GENERATE(as<std::string>(), "5000", "4294967296", "1537228672809129302", "9223372036854775807",
                                       "18446744073709551615");
    const std::string good = one_face(encoding, "uchar", 3, {0, 1, 2});
    const std::string left = ", but " + std::to_string(good.size() - good.find("end_header\n") - 11) + " bytes are left";
    malformed(replaced(good, "vertex 4", "vertex " + count), "the header counts " + count + " of element 'vertex'" + left);
    malformed(replaced(good, "face 1", "face " + count), "the header counts " + count + " of element 'face', but ");
    malformed(replaced(replaced(good, "vertex 4", "vertex 0"), "face 1", "face " + count), "holds faces but no vertices");
}

TEST_CASE("PLY lists with a wrong length are refused", "[input][ply]") {
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const std::string good = one_face(encoding, "int", 3, {0, 1, 2});
    const auto face = static_cast<std::int64_t>(good.find("end_header\n") + 11 + (encoding == "ascii" ? 24 : 48));
    for (const double count : {4.0, 5.0, 100000.0, 2147483647.0}) {
        const Error error =
            malformed(one_face(encoding, "int", count, {0, 1, 2}), "property 'vertex_indices' of 'face' 0: ");
        CHECK(error.byte_offset >= face);
    }
    for (const double count : {-1.0, -3.0, -2147483648.0}) {
        const std::string says = "a list of " + std::to_string(static_cast<long>(count)) + " numbers";
        CHECK(malformed(one_face(encoding, "int", count, {0, 1, 2}), says).byte_offset == face);
    }
    for (const double bad : {2.5, double{INFINITY}, std::nan(""), 1e300}) {
        if (encoding != "ascii") {
            malformed(one_face(encoding, "double", bad, {0, 1, 2}), "expected the length of a list, found ");
        }
    }
}

TEST_CASE("PLY indices out of range are refused", "[input][ply]") {
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const std::size_t count = GENERATE(3U, 4U);
    const double index = GENERATE(4.0, -1.0, 2147483647.0, -2147483648.0);
    for (std::size_t corner = 0; corner < count; ++corner) {
        std::vector<double> face = {0, 1, 3, 2};
        face.resize(count);
        face[corner] = index;
        const std::string bytes = one_face(encoding, "uchar", static_cast<double>(count), face);
        const std::string number = std::to_string(static_cast<long>(index));
        const Error error =
            malformed(bytes, "property 'vertex_indices' of 'face' 0: index " + number + ", but there are 4 vertices");
        const auto offset = static_cast<std::size_t>(error.byte_offset);
        if (encoding == "ascii") {
            CHECK_THAT(error.message, Contains(": line 14, byte "));
            CHECK(bytes.compare(offset, 1, number, 0, 1) == 0);
        } else {
            CHECK(offset == bytes.size() - 4 * (count - corner));
        }
    }
}

TEST_CASE("PLY polygons with a corner that is not finite are refused", "[input][ply]") {
    const PlyVariant how{GENERATE(as<std::string_view>(), "binary_little_endian", "binary_big_endian")};
    std::vector<double> xyz = corners;
    xyz[7] = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
    malformed(ply(how, xyz, {{0, 1, 3}, {0, 1, 2, 3}}), ": vertex 2 of this face has a coordinate that is not finite");
}

}  // namespace lamella::ply_test
