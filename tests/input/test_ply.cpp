// PLY in all its forms. What is refused or warned of: cases/ply.txt.
#include <random>

#include "read.hpp"

namespace lamella::input_test {

namespace {

Contents read_ply(const std::string& bytes) {
    return read(dir.write("a.ply", bytes));
}

Ply drawn_form(std::mt19937& random) {
    constexpr const char* types[2][8] = {{"char", "uchar", "short", "ushort", "int", "uint", "float", "double"},
                                         {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"}};
    const auto type = [&] { return types[random() % 2][random() % 8]; };
    Ply form{ply_encodings[random() % 3], type(), type(), type(), random() % 2 == 0 ? "vertex_indices" : "vertex_index"};
    std::shuffle(form.axes.begin(), form.axes.end(), random);
    form.faces_first = random() % 2 == 0;
    form.extra_numbers = random() % 2 == 0;
    form.extra_lists = random() % 2 == 0;
    form.extra_elements = random() % 2 == 0;
    return form;
}

}  // namespace

TEST_CASE("PLY of every encoding, type of number and order, with unknown properties, gives the same mesh", "[input][ply]") {
    std::mt19937 random(1);
    PolygonMesh polygons = cube();
    polygons.faces.insert(polygons.faces.begin() + 2, {{}, {0}, {0, 1}});
    for (int draw = 0; draw < 2000; ++draw) {
        const Ply form = drawn_form(random);
        const bool quads = random() % 2 == 0;
        CAPTURE(draw, form.encoding, form.coordinate, form.count, form.index, form.axes, form.faces_first, quads);
        const Contents contents = read_ply(form(quads ? polygons : triangulated(cube())));
        CHECK(contents.triangles == cube().triangles());
        CHECK(contents.mesh.text == (form.encoding == "ascii"));
        REQUIRE(contents.warnings.size() == (quads ? 1 : 0));
        const MeshFile again = value_of(read_mesh(dir / "a.ply", {.scalars = true}));
        CHECK((triangles_of(again) == contents.triangles && again.warnings == contents.mesh.warnings));
        REQUIRE(again.scalars.size() == (form.extra_numbers ? 8U : 0U));  // beside x, y and z
        for (std::size_t i = 0; i < again.scalars.size(); ++i) {
            CHECK(again.scalars[i].integers == (i % 2 == 1));
            CHECK(std::ranges::count(again.scalars[i].values.span(), i % 2 == 1 ? 200 : -0.5) == 8);
        }
        CHECK((!quads || contents.warnings[0].starts_with("left out 3 faces of fewer than three corners")));
    }
}

TEST_CASE("PLY coordinates keep their precision", "[input][ply]") {
    const std::string encoding = GENERATE(from_range(ply_encodings));
    for (const auto& [type, x] : {std::pair<std::string, double>("double", 0.1 + 0x1p-40),
                                  {"int", -2147483648.0},
                                  {"int", 16777217},
                                  {"uint", 4294967295.0},
                                  {"float", -0.375},
                                  {"short", -32768},
                                  {"ushort", 65535},
                                  {"char", -128},
                                  {"uchar", 255}}) {
        const Contents contents = read_ply(Ply{encoding, type}({{x, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}}}));
        CHECK((contents.mesh.vertex_type == Number::f64) == (type == "double" || type == "int" || type == "uint"));
        CHECK(contents.triangles[0][0] == (encoding == "ascii" && type == "double" ? 0.1 : x));  // six decimals
    }
}

TEST_CASE("PLY floats of the machine's own byte order stay where they lie", "[input][ply]") {
    Ply form{"binary_little_endian", GENERATE("float", "double")};
    form.faces_first = GENERATE(false, true);
    const std::string bytes = form(cube());
    const MeshFile mesh = read_one(dir.write("a.ply", bytes));
    CHECK(mesh.bytes.size() == bytes.size());
    CHECK(mesh.first_offset + mesh.vertex_count * mesh.stride <= bytes.size());
    form.axes = {0, 2, 1};
    CHECK(read_one(dir.write("a.ply", form(cube()))).first_offset == 0);
}

TEST_CASE("PLY triangle strips alternate and begin again after -1", "[input][ply]") {
    Ply form{GENERATE(from_range(ply_encodings)), "float", "int"};
    form.faces_first = GENERATE(false, true);
    const PolygonMesh mesh{{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0},
                           {},
                           {{0, 1, 2, 3, 4, -1, 2, 1, 0, -1, -1, 0, 1, 4, -1, 0, 1, -1}, {0, 1, 1, 2, 3}}};
    const MeshFile read = read_one(dir.write("a.ply", form(mesh)));
    const std::vector<std::uint32_t> indices(read.indices.begin(), read.indices.end());
    CHECK(indices == std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3, 2, 3, 4, 2, 1, 0, 0, 1, 4, 1, 2, 3});
}

TEST_CASE("binary PLY is read after a header of any line ends, and before a tail", "[input][ply]") {
    const Ply form{GENERATE("binary_little_endian", "binary_big_endian"), "int"};
    // The first byte of the data is one that ends lines: it is data.
    PolygonMesh mesh = triangulated(cube());
    mesh.xyz[0] = form.encoding == "binary_big_endian" ? 0x0A000000 : 0x0A;
    const std::string bytes = form(mesh);
    const std::size_t body = bytes.find("end_header\n") + 11;
    for (const auto& [what, by] : {std::pair("\n", "\r\n"),
                                   {"\n", "\r"},
                                   {"\n", " \t\n"},
                                   {" ", " \t "},
                                   {"property", "\tproperty"},
                                   {"\nproperty", "\n\n \nproperty"}}) {
        CHECK(read_ply(replaced(bytes.substr(0, body), what, by) + bytes.substr(body)).triangles == mesh.triangles());
    }
}

TEST_CASE("text PLY parsed in many pieces gives every face once, in order", "[input][ply][threads]") {
    const PolygonMesh sphere = mesh_of(shapes::octasphere({1, 2, 3}, 20, 7));  // 5 MB
    // Fewer triangles in a piece than its lines and words let expect. Without such: tests/golden.
    PolygonMesh mesh = sphere;
    for (std::ptrdiff_t at = 20; at < 120'000; at += 30'000) {
        mesh.faces.insert(mesh.faces.begin() + at, {{0}, {1, 2}});
    }
    const std::string by_lines = Ply{.coordinate = "double", .faces_first = true, .extra_elements = true}(mesh);
    const Contents contents = read_ply(by_lines);
    REQUIRE(contents.triangles.size() == sphere.faces.size());
    for (std::size_t i = 0; i < 3 * sphere.faces.size(); ++i) {
        REQUIRE(contents.mesh.indices[i] == sphere.faces[i / 3][i % 3]);
    }
    CHECK(contents.warnings.size() == 1);
    CHECK((read_ply(replaced(by_lines, "end_header\n", "end_header\n\n")).triangles == contents.triangles));
}

}  // namespace lamella::input_test
