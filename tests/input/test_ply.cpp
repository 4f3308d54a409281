#include <algorithm>
#include <string>

#include "engine/shapes.hpp"
#include "ply_writer.hpp"
#include "read.hpp"

namespace lamella::ply_test {

using namespace input_test;

namespace {

const shapes::Indexed& cube() {
    static const shapes::Indexed mesh = shapes::indexed(shapes::box({1, 2, 3}, {21, 22, 23}));
    return mesh;
}

using Triangles = std::vector<std::array<double, 9>>;

/// The triangles of a file that must be readable.
Triangles read(const std::string& bytes) {
    return read_triangles(dir.write("a.ply", bytes));
}

Triangles triangles_in(const shapes::Indexed& mesh) {
    Triangles triangles(mesh.indices.size() / 3);
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
        std::copy_n(mesh.xyz.begin() + 3 * mesh.indices[i], 3, triangles[i / 3].begin() + 3 * (i % 3));
    }
    return triangles;
}

}  // namespace

TEST_CASE("PLY of every encoding and type of number gives the same mesh", "[input][ply]") {
    const Triangles expected = triangles_in(cube());
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const std::size_t coordinate = GENERATE(range<std::size_t>(0, 8));
    for (std::size_t count = 0; count < 8; ++count) {
        for (std::size_t index = 0; index < 8; ++index) {
            PlyVariant how;
            how.encoding = encoding;
            how.coordinate = count % 2 == 0 ? ply_types[coordinate] : ply_sized_types[coordinate];
            how.count = index % 2 == 0 ? ply_types[count] : ply_sized_types[count];
            how.index = count % 2 == 0 ? ply_types[index] : ply_sized_types[index];
            CAPTURE(how.encoding, how.coordinate, how.count, how.index);
            CHECK(read(ply(how, cube())) == expected);
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
            CHECK(read(ply(how, cube())) == expected);
        } while (std::next_permutation(how.axes.begin(), how.axes.end()));
    }
}

TEST_CASE("PLY coordinates keep their precision", "[input][ply]") {
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const auto read = [&](std::string_view type, double x) {
        PlyVariant how;
        how.encoding = encoding;
        how.coordinate = type;
        const MeshFile mesh = read_one(dir.write("a.ply", ply(how, {x, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}})));
        CHECK((mesh.vertex_type == Number::f64) == (type == "double" || type == "int" || type == "uint"));
        CHECK(mesh.text == (encoding == "ascii"));
        return input_test::triangles_of(mesh)[0][0];
    };
    CHECK(read("double", 0.1 + 0x1p-40) == Approx(0.1 + 0x1p-40).epsilon(encoding == "ascii" ? 1e-5 : 1e-16));
    CHECK(read("int", -2147483648.0) == -2147483648.0);
    CHECK(read("int", 16777217) == 16777217);
    CHECK(read("uint", 4294967295.0) == 4294967295.0);
    CHECK(read("float", -0.375) == -0.375);
    CHECK(read("short", -32768) == -32768);
    CHECK(read("ushort", 65535) == 65535);
    CHECK(read("char", -128) == -128);
    CHECK(read("uchar", 255) == 255);
}

TEST_CASE("PLY floats of the machine's own byte order stay where they lie", "[input][ply]") {
    PlyVariant how;
    how.encoding = "binary_little_endian";
    how.faces_first = GENERATE(false, true);
    how.coordinate = GENERATE(as<std::string_view>(), "float", "double");
    const std::string bytes = ply(how, cube());
    const MeshFile mesh = read_one(dir.write("a.ply", bytes));
    CHECK(mesh.bytes.size() == bytes.size());
    CHECK(mesh.first_offset + mesh.vertex_count * mesh.stride <= bytes.size());
    how.axes = {0, 2, 1};
    CHECK(read_one(dir.write("a.ply", ply(how, cube()))).first_offset == 0);
}

TEST_CASE("PLY polygons are cut into triangles", "[input][ply]") {
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    how.faces_first = GENERATE(false, true);
    // A prism over an L of six corners, concave at the last one, 2 high.
    const std::vector<double> xyz = {0, 0, 0, 3, 0, 0, 3, 1, 0, 1, 1, 0, 1, 3, 0, 0, 3, 0,
                                     0, 0, 2, 3, 0, 2, 3, 1, 2, 1, 1, 2, 1, 3, 2, 0, 3, 2};
    const Faces faces = {{5, 4, 3, 2, 1, 0}, {6, 7, 8, 9, 10, 11}, {0, 1, 7, 6},   {1, 2, 8, 7},
                         {2, 3, 9, 8},       {3, 4, 10, 9},        {4, 5, 11, 10}, {5, 0, 6, 11}};
    const std::vector<Corners> triangles = corners_of(read_indexed(dir.write("a.ply", ply(how, xyz, faces))));
    CHECK(triangles.size() == 2 * 4 + 6 * 2);
    CHECK(six_volumes(triangles) == Approx(6 * 10));
}

TEST_CASE("PLY faces of fewer than three vertices are left out and reported", "[input][ply]") {
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    Faces faces = triangles_of(cube());
    faces.insert(faces.begin() + 1, {{}, {0}, {0, 1}});
    const auto path = dir.write("a.ply", ply(how, cube().xyz, faces));
    CHECK(read_triangles(path) == triangles_in(cube()));
    CHECK(warnings_of(path) == Texts{"left out 3 faces of fewer than three vertices"});
    CHECK(read_error(dir.write("b.ply", ply(how, cube().xyz, {{0, 1}}))).code == ErrorCode::empty_mesh);
}

TEST_CASE("PLY triangle strips alternate and begin again after -1", "[input][ply]") {
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const bool strips_first = GENERATE(false, true);
    const std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
    PlyWriter out(encoding);
    if (!strips_first) {
        detail::add_vertices(out, {}, xyz);
    }
    out.header("element tristrips 2").header("property list int int vertex_indices");
    out.list("int", "int", {0, 1, 2, 3, 4, -1, 2, 1, 0, -1, -1, 0, 1, 4, -1, 0, 1, -1}).end_row();
    out.list("int", "int", {0, 1, 1, 2, 3}).end_row();
    if (strips_first) {
        detail::add_vertices(out, {}, xyz);
    }
    const MeshFile mesh = read_one(dir.write("a.ply", out.file()));
    const std::vector<std::uint32_t> indices(mesh.indices.begin(), mesh.indices.end());
    CHECK(indices == std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3, 2, 3, 4, 2, 1, 0, 0, 1, 4, 1, 2, 3});
}

TEST_CASE("PLY headers are read with any line ends and white space", "[input][ply]") {
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    how.coordinate = "int";
    // The first byte of the data is one that ends lines: it is data.
    std::vector<double> xyz = cube().xyz;
    xyz[0] = how.encoding == "binary_big_endian" ? 0x0A000000 : 0x0A;
    const std::string bytes = ply(how, xyz, triangles_of(cube()));
    const std::size_t body = bytes.find("end_header\n") + 11;
    const Triangles expected = read(bytes);
    const auto [what, by] = GENERATE(table<std::string, std::string>({{"\n", "\r\n"},
                                                                      {"\n", "\r"},
                                                                      {"\n", " \t\n"},
                                                                      {" ", " \t "},
                                                                      {"property", "\tproperty"},
                                                                      {"\nproperty", "\n\n \nproperty"}}));
    CHECK(read(replaced(bytes.substr(0, body), what, by) + bytes.substr(body)) == expected);
}

TEST_CASE("ASCII PLY rows need not be lines", "[input][ply]") {
    PlyVariant how;
    how.extra_elements = GENERATE(false, true);
    how.faces_first = GENERATE(false, true);
    const std::string bytes = ply(how, cube());
    const std::size_t body = bytes.find("end_header\n") + 11;
    const auto [what, by] = GENERATE(table<std::string, std::string>(
        {{"\n", "\r\n"}, {"\n", "\r"}, {"\n", " "}, {"\n", "\n\n"}, {"\n", " \n \t\n"}, {" ", "\n"}, {" ", "\t \t"}}));
    CHECK(read(bytes.substr(0, body) + replaced(bytes.substr(body), what, by)) == triangles_in(cube()));
    CHECK(read(bytes.substr(0, bytes.size() - 1)) == triangles_in(cube()));
    CHECK(read(bytes + "\n \r\n\n") == triangles_in(cube()));
    CHECK(read("\xEF\xBB\xBF" + bytes) == triangles_in(cube()));
}

TEST_CASE("ASCII PLY is read in every accepted spelling of numbers", "[input][ply]") {
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty float y\nproperty int z\n"
        "element face 1\nproperty list uchar uint vertex_indices\nend_header\n";
    const std::string vertices = "+1.5e0 -.5 1e1\n1E-400 5. 0007\n-0.0 +0 3.25\n";
    const Triangles expected = {{1.5, -0.5, 10, 0, 5, 7, 0, 0, 3.25}};
    CHECK(read(header + vertices + "3 0 1 2\n") == expected);
    CHECK(read(header + vertices + "+3 0.0 1e0 2.\n") == expected);
    CHECK(read(header + vertices + "003 -0 0000000000000000000000001 2\n") == expected);
}

TEST_CASE("ASCII PLY parsed in many pieces gives every face once, in order", "[input][ply][threads]") {
    const shapes::Indexed sphere = shapes::indexed(shapes::octasphere({1, 2, 3}, 20, 7));  // 5 MB
    Faces faces = triangles_of(sphere);
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
    const auto path = dir.write("a.ply", by_lines);
    const Triangles triangles = read_triangles(path);
    CHECK(triangles.size() == faces.size() - small);
    const MeshFile mesh = read_one(path);
    CHECK(std::equal(mesh.indices.begin(), mesh.indices.end(), sphere.indices.begin(), sphere.indices.end()));
    CHECK(mesh.warnings.size() == 1);
    const std::size_t body = by_lines.find("end_header\n") + 11;
    CHECK(read(by_lines.substr(0, body) + "\n" + by_lines.substr(body)) == triangles);
}

TEST_CASE("bytes after the last PLY element give a warning", "[input][ply]") {
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    const auto path = dir.write("a.ply", ply(how, cube()) + "tail");
    CHECK(read_triangles(path) == triangles_in(cube()));
    CHECK(warnings_of(path) == Texts{"ignored 4 bytes after the last element"});
}

}  // namespace lamella::ply_test
