#include <functional>
#include <string>

#include "cube.hpp"

namespace lamella::input_test {

using Catch::Contains;

namespace {

std::string vertices_text(const std::string& tail = "") {
    std::string text;
    for (std::size_t v = 0; v < cube_corners.size(); ++v) {
        text += "v " + cube_corner_text(v) + tail + "\n";
    }
    return text;
}

/// The cube's sides with each corner, from 0, written by `corner`.
std::string sides_text(const std::function<std::string(std::uint32_t)>& corner) {
    std::string text;
    for (const auto& side : cube_sides) {
        text += "f";
        for (const std::uint32_t v : side) {
            text += " " + corner(v);
        }
        text += "\n";
    }
    return text;
}

std::string plain(std::uint32_t v) {
    return std::to_string(v + 1);
}

std::string cube() {
    return vertices_text() + sides_text(plain);
}

/// A corner of the cube and a face; `face` is line 4.
std::string with_face(const std::string& face) {
    return "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + face + "\n";
}

}  // namespace

TEST_CASE("an OBJ cube in every form slices like the same cube as STL", "[input][obj]") {
    const std::uint64_t expected = cube_hash();
    const std::string v = vertices_text();
    const auto sides = [](const std::string& tail) {
        return sides_text([&tail](std::uint32_t corner) { return plain(corner) + tail; });
    };
    const std::string from_the_end = sides_text([](std::uint32_t c) { return std::to_string(static_cast<int>(c) - 8); });
    const std::string skipped = "vn 0 0 1\nvt 0.5 0.5\nvp 1\ns off\ng a b\no f\nusemtl red\nl 1 2\np 1\n";
    const std::string text = GENERATE_COPY(
        as<std::string>(), cube(), v + sides("/7"), v + sides("//12"), v + sides("/-3/-4"), v + sides("//"),
        v + from_the_end, v + sides(" \\\n"), v + sides("\\\r\n "), sides_text(plain) + v,
        vertices_text(" 1.0") + sides_text(plain), replaced(cube(), "f ", "fo "),
        vertices_text(" 0.5 0.25 1 1") + sides_text(plain), vertices_text(" \\\n 1 # f 1 2 3") + sides_text(plain),
        replaced(cube(), "\n", "\r\n"), replaced(cube(), "\n", "\r"), replaced(cube(), "\n", " # 1 2 3 \\\n\n"),
        replaced(cube(), " ", " \t "), "  " + replaced(cube(), "\n", "\n\t"), "\xEF\xBB\xBF# made by hand\n\n" + cube(),
        cube().substr(0, cube().size() - 1), replaced(cube(), "f ", skipped + "f "),
        "mtllib f.mtl\n" + replaced(cube(), "f ", "curv 0 1 \\\n1 2 \\\r\n3\nf "));
    INFO(text);
    CHECK(hash_of(dir.write("cube.obj", text)) == expected);
}

TEST_CASE("a backslash at the end of an OBJ name loses no vertex and no face", "[input][obj]") {
    const std::uint64_t expected = cube_hash();
    const std::string end = GENERATE(as<std::string>(), "\n", "\r\n", "\r");
    for (const char* name : {"usemtl textures\\", "g a \\", "vn 0 0 1\\", "shader c:\\", "usemtl a\\\ng b\\"}) {
        for (const char* next : {"f ", "fo ", " v "}) {
            const std::string statement = *next == ' ' ? "v " : "f ";
            const std::string text = replaced(cube(), statement, name + ("\n" + std::string(next)));
            const std::filesystem::path path = dir.write("cube.obj", replaced(text, "\n", end));
            CHECK(hash_of(path) == expected);
            CHECK_THAT(read_mesh(path)->warnings.back(),
                       Contains(" vertices and faces after a line that ends in a backslash, the first in line "));
        }
    }
    // Joined all the same are lines of which none is a vertex or a face.
    CHECK(hash_of(dir.write("cube.obj", replaced(cube(), "f ", "g a\\\nb \\\n f1 v2\nf "))) == expected);
}

TEST_CASE("an OBJ number that a backslash may cut is refused", "[input][obj]") {
    refuses(dir.write("a.obj", with_face("f 1 2\\\n3")),
            ": line 4, byte 28: malformed vertex number '2\\': put a blank before the backslash");
    refuses(dir.write("b.obj", "v 1\\\r\n0 0 0\n" + cube()),
            ": line 1, byte 2: malformed coordinate '1\\': put a blank before the backslash");
}

TEST_CASE("a relative OBJ reference counts back from its own line", "[input][obj]") {
    std::string text;
    std::vector<std::array<double, 9>> expected;
    for (int i = 0; i < 70'000; ++i) {  // 3 MB: several pieces
        const std::string x = std::to_string(i);
        text += "v " + x + " 0 0\nv " + x + " 1 0\nv " + x + " 0 1\nf -3 -2 -1\n";
        const double d = i;
        expected.push_back({d, 0, 0, d, 1, 0, d, 0, 1});
    }
    CHECK((read_triangles(dir.write("a.obj", text)) == expected));
}

TEST_CASE("a concave OBJ face is cut along the diagonal within it", "[input][obj]") {
    const std::string arrow = "v 0 0 0\nv 4 4 0\nv 0 1 0\nv -4 4 0\n";
    CHECK(read_triangles(dir.write("a.obj", arrow + "f 2 3 4 1\n")) ==
          std::vector<std::array<double, 9>>{{0, 0, 0, 4, 4, 0, 0, 1, 0}, {-4, 4, 0, 0, 0, 0, 0, 1, 0}});
}

TEST_CASE("OBJ numbers are read as doubles", "[input][obj]") {
    const auto first = [&](const std::string& number) {
        return read_triangles(dir.write("a.obj", "v " + number + " 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")).at(0)[0];
    };
    for (const auto& [text, number] : {std::pair("0.1", 0.1), {"-1E-3", -1e-3}, {"1e-400", 0}, {"1.5\\\n", 1.5}}) {
        CHECK(first(text) == number);
    }
    CHECK(first("+123.456789012345678") == 123.456789012345678);
    CHECK(first("1." + std::string(3000, '0') + "1") == 1);
}

TEST_CASE("malformed OBJ coordinates are refused with line and byte", "[input][obj]") {
    const std::string number = GENERATE(as<std::string>(), "nan", "inf", "-inf", "1e999", "1,5", "1.2.3", "--1", "+-1", "+",
                                        "-", ".", "e5", "0x10", "abc", "1\\", "\\1", "1/2");
    const auto path = dir.write("a.obj", "# x\nv 0 " + number + " 0\nv 1 1 1\nf 1 2 1\n");
    const Error error = refuses(path, ": line 2, byte 8: ", "'" + number + "'");
    CHECK(error.code == ErrorCode::malformed_mesh);
    CHECK(error.byte_offset == 8);
}

TEST_CASE("OBJ vertices of too few or too many numbers are refused", "[input][obj]") {
    refuses(dir.write("a.obj", "v 1 2\nv 3 4 5\n"),
            "line 1, byte 5: expected a coordinate (a vertex has three), found the end of the line");
    refuses(dir.write("b.obj", "v 1 2 3\nv"), "line 2, ", "the end of the file");
    refuses(dir.write("c.obj", "v 1 2 3 4 5 6 7 8\n"), "byte 16: expected the end of the line, found '8'");
    refuses(dir.write("d.obj", "v 1 2 3 red\n"), "byte 8: ", "found 'red'");
}

TEST_CASE("impossible OBJ faces are refused with line and byte", "[input][obj]") {
    const auto refused = [&](const std::string& face) {
        const Error error = read_error(dir.write("a.obj", with_face(face)));
        CHECK(error.code == ErrorCode::malformed_mesh);
        CHECK_THAT(error.message, Contains(": line 4, byte "));
        return error.message.substr(error.message.find("byte"));
    };
    CHECK(refused("f 1 2 0") == "byte 30: vertex number out of range: the file has 3 vertices, found '0'");
    CHECK(refused("f 1 2 4") == "byte 30: vertex number out of range: the file has 3 vertices, found '4'");
    CHECK(refused("f 1 2 3 4294967297") ==
          "byte 32: vertex number out of range: the file has 3 vertices, found '4294967297'");
    CHECK(refused("f 1 2 99999999999999999999999/1") ==
          "byte 30: vertex number out of range: the file has 3 vertices, found '99999999999999999999999/1'");
    CHECK(refused("f -1 -2 -4") == "byte 32: vertex number out of range: 3 vertices precede, found '-4'");
    CHECK(refused("f 1 2 -0") == "byte 30: vertex number out of range: 3 vertices precede, found '-0'");
    CHECK(refused("f 1 4") == "byte 28: vertex number out of range: the file has 3 vertices, found '4'");
    CHECK(refused("fo 1 2 4") == "byte 31: vertex number out of range: the file has 3 vertices, found '4'");
    refuses(dir.write("b.obj", "v 0 0 0\nv 1 0 0\nf -1 -2 -3\nv 0 1 0\n"),
            "line 3, byte 24: vertex number out of range: 2 vertices precede");
    for (const char* word :
         {"x", "1.5", "1.01", "1.0x", "+1", "1/a", "1/2/3/4", "1/-", "1//-", "/1", "-", "--1", "1e0", "3#", "1\\2"}) {
        CHECK(refused("f 1 2 " + std::string(word)) == "byte 30: malformed vertex number '" + std::string(word) + "'");
    }
}

TEST_CASE("OBJ vertex numbers with decimals that are 0 give a warning", "[input][obj]") {
    const auto path = dir.write("a.obj", with_face("f 1 2 3\nf 3.0 2 1.00"));
    CHECK((read_triangles(path) ==
           std::vector<std::array<double, 9>>{{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 0, 1, 0, 0, 0, 0, 0}}));
    CHECK(warnings_of(path) == Texts{"2 vertex numbers with decimals, which are 0, the first in line 5: '3.0'"});
}

TEST_CASE("OBJ faces of fewer than three corners are left out with a warning, text without faces is empty", "[input][obj]") {
    const auto path = dir.write("a.obj", with_face("f 1 2\nf 1 2 3\nf\nfo 1 # 2 3\nf 3 2 1"));
    CHECK((read_triangles(path) ==
           std::vector<std::array<double, 9>>{{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 0, 1, 0, 0, 0, 0, 0}}));
    CHECK(warnings_of(path) == Texts{"left out 3 faces of fewer than three corners, the first in line 4"});
    for (const auto& [text, says] : {std::pair(with_face("f 1 2"), "holds no face of three corners or more"),
                                     {vertices_text(), "holds no faces"},
                                     {"# nothing\n", ""},
                                     {"o part\n", "holds no faces"}}) {
        CHECK(refuses(dir.write("b.obj", text), says).code == ErrorCode::empty_mesh);
    }
}

TEST_CASE("unread OBJ statements that may hold a shape give one warning", "[input][obj]") {
    const auto warnings = [&](const std::string& statements) {
        const auto path = dir.write("a.obj", cube() + statements);
        CHECK(read_one(path).triangle_count == 12);
        return warnings_of(path);
    };
    const auto ignored = [&](const std::string& what) { return Texts{"ignored " + what}; };
    CHECK(warnings("g a\no b\ns 1\nusemtl c\nvn 0 0 1\nvt 0 0\nvp 1\nl 1 2\np 1\n# surf\nlod 3\nmtllib surf\n").empty());
    CHECK(warnings("surf 0 1 0 1 1 2\n") == ignored("1 statement that is not read, the first in line 15: 'surf'"));
    CHECK(warnings("vn 0 0 1\ncstype bezier\ncurv2 1 2\nend\ncurv 0 1 \\\n surf\ncall x.obj\n") ==
          ignored("3 statements that are not read, the first in line 17: 'curv2'"));
    CHECK(warnings("F 1 2 3\n") == ignored("1 statement that is not read, the first in line 15: 'F'"));
    std::string far;  // several pieces
    for (int i = 0; i < 300'000; ++i) {
        far += "vn 0 0 1\n";
    }
    CHECK(warnings(far + "what\n" + far + "what") ==
          ignored("2 statements that are not read, the first in line 300015: 'what'"));
}

TEST_CASE("the first error of an OBJ file is reported on any number of threads", "[input][obj][threads]") {
    std::string text;
    for (int i = 0; i < 200'000; ++i) {  // 4 MB
        text += "v 0.25 0.5 0.125\n";
    }
    text += "f 1 2 3\n";
    for (const std::size_t near : {3'300'000U, 2'200'000U}) {
        text[text.find("0.5", near) + 1] = 'x';
    }
    CHECK(read_error(dir.write("a.obj", text)).byte_offset == static_cast<std::int64_t>(text.find("0x5")));
}

TEST_CASE("an OBJ file cut anywhere is read or refused, never misread", "[input][obj]") {
    const std::string whole =
        vertices_text(" 1 \\\n 0.5 0.5") + sides_text([](std::uint32_t c) { return plain(c) + "/1/2"; });
    const std::size_t first_face = whole.find("f ");
    for (std::size_t length = 1; length < whole.size(); ++length) {
        const Result<MeshFile> mesh = read_mesh(dir.write("a.obj", whole.substr(0, length)));
        if (length <= first_face) {
            REQUIRE_FALSE(mesh.ok());
        } else if (mesh) {
            CHECK(mesh->vertex_count == 8);
            CHECK(mesh->triangle_count <= 12);
        } else {
            CHECK((mesh.error().code == ErrorCode::malformed_mesh || mesh.error().code == ErrorCode::empty_mesh));
        }
    }
}

TEST_CASE("pieces of OBJ text end neither within a statement nor within a comment", "[input][obj][threads]") {
#ifdef LAMELLA_TESTS_SANITIZED
    const std::string end = "\r\n";
#else
    const std::string end = GENERATE(as<std::string>(), "\n", "\r\n", "\r");
#endif
    std::string text = "v 0 0 0" + end + "v 1 0 0" + end + "v 0 1 0" + end + "f";
    for (std::size_t i = 0; i < 500'000; ++i) {  // one face on half a million lines
        text += " " + std::to_string(i % 3 + 1) + "\\" + end;
    }
    text += " 1" + end + "f 1 2 3" + end;
    CHECK(read_triangles(dir.write("a.obj", text)).size() == 500'000);
}

TEST_CASE("an OBJ face that expands beyond the memory limit is refused before it does", "[input][obj]") {
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
    for (int i = 0; i < 400'000; ++i) {
        text += " 1";
    }
    CHECK_THAT(message_beyond(4'000'000, dir.write("a.obj", text)),
               Contains("more than the 4000000 bytes that reading it may"));
}

TEST_CASE("hostile OBJ faces are refused with their line", "[input][obj]") {
    const std::string face = "f" + entangled_corners(1);
    refuses(dir.write("a.obj", with_face("f 1 2 3\n" + face)), "line 5, byte 32: this face is too entangled");
    const std::string after_small = with_face("f 1 2\nf 1 2 3\nf 2 \\\n 3\n" + face);
    refuses(dir.write("b.obj", after_small), "line 8, byte 47: this face is too entangled");
}

TEST_CASE("OBJ is known by its first statement", "[input][obj]") {
    for (const char* head : {"", "# a\n", "mtllib a.mtl\n", "g part\n", "vn 0 0 1\n"}) {
        CHECK(read_one(dir.write("a", head + cube())).format == MeshFormat::obj);
    }
    refuses(dir.write("b.obj", "vertex 1 2 3\n"), "text that begins with 'vertex 1 2 3'");
}

}  // namespace lamella::input_test
