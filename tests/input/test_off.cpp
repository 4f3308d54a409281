#include <string>

#include "cube.hpp"

namespace lamella::input_test {

using Catch::Contains;

namespace {

std::string body(const std::string& vertex_tail = "", const std::string& face_tail = "") {
    std::string text;
    for (std::size_t v = 0; v < cube_corners.size(); ++v) {
        text += cube_corner_text(v) + vertex_tail + "\n";
    }
    for (const auto& side : cube_sides) {
        text += "4";
        for (const std::uint32_t v : side) {
            text += " " + std::to_string(v);
        }
        text += face_tail + "\n";
    }
    return text;
}

std::string cube() {
    return "OFF\n8 6 12\n" + body();
}

/// Three vertices and a face; `face` is line 6.
std::string with_face(const std::string& face) {
    return "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n" + face + "\n";
}

/// The message of a malformed file, from its line on.
std::string refusal(const std::string& text) {
    const Error error = read_error(dir.write("a.off", text));
    CHECK(error.code == ErrorCode::malformed_mesh);
    return error.message.substr(error.message.find(": line") + 2);
}

}  // namespace

TEST_CASE("an OFF cube in every form slices like the same cube as STL", "[input][off]") {
    const std::uint64_t expected = cube_hash();
    const std::string text =
        GENERATE_COPY(as<std::string>(), cube(), "OFF 8 6 12\n" + body(), "OFF 8 6\n" + body(),
                      "OFF # 1 2 3\n\n# 4\n 8 6 0 # 5\n\n" + body(), "COFF\n8 6 0\n" + body(" 255 0 0 255"),
                      "NOFF\n8 6 0\n" + body(" 0 0 1"), "CNOFF\n8 6 0\n" + body(" 0 0 1 0.5 0.5 0.5 1"),
                      "STCNOFF\n8 6 0\n" + body(" 0 0 1 0.5 0.5 0.5 1 0 0"), "OFF\n8 6 0\n" + body("", " 255 128 0"),
                      "OFF\n8 6 0\n" + body(" # x", " 0.1 0.2 0.3 1 # 7"), "OFF\n8 6 0\n" + body("\n\n# 1 2 3\n", "\t7"),
                      replaced(cube(), "\n", "\r\n"), replaced(cube(), "\n", "\r"), replaced(cube(), " ", " \t "),
                      "\xEF\xBB\xBF# head\n" + cube(), cube().substr(0, cube().size() - 1));
    INFO(text);
    CHECK(hash_of(dir.write("cube.off", text)) == expected);
}

TEST_CASE("an OFF cube whose lines end elsewhere slices like the same cube as STL, with a warning", "[input][off]") {
    const std::uint64_t expected = cube_hash();
    const auto warnings = [&](const std::string& text) {
        const auto path = dir.write("cube.off", text);
        CHECK(hash_of(path) == expected);
        return warnings_of(path);
    };
    const auto why = [&](const std::string& text) {
        const std::vector<std::string> all = warnings(text);
        REQUIRE(all.size() == 1);
        const std::string start = "was read number by number, as it is not one vertex or one face a line (";
        CHECK(all[0].substr(0, start.size()) == start);
        return all[0].substr(start.size());
    };
    const auto broken = [](const std::string& text, const std::string& end) { return replaced(text, "\n4 ", "\n4" + end); };
    CHECK(why(broken(cube(), "\n")).find("line 11, byte ") == 0);
    CHECK(why(broken(cube(), " # corners\n\n")).find("line 11, byte ") == 0);
    CHECK(why(broken("OFF\n8 6 12\n" + body("", " 255 128 0"), "\n")).find("line 11, byte ") == 0);
    CHECK(why(broken("CNOFF\n8 6 0\n" + body(" 0 0 1 0.5 0.5 0.5 1", " 7"), "\r\n")).find("line 11, byte ") == 0);
    CHECK(why(replaced(cube(), " ", "\n")).find("line 4, byte ") == 0);
    CHECK(why(replaced(cube(), "\n", " ") + "\n").find("line 1, byte ") == 0);
    const std::string faces = body().substr(body().find("\n4 ") + 1);
    CHECK(why("OFF\n8 6 0\n" + body().substr(0, body().find("\n4 ") + 1) + replaced(faces, "\n", " "))
              .find("line 11, byte ") == 0);
    CHECK(warnings("OFF\n8\n6\n" + body()).empty());
    CHECK(warnings("OFF\n8\n# faces\n6 0\n" + body()).empty());
}

TEST_CASE("OFF whose lines end elsewhere is refused where it is malformed", "[input][off]") {
    const auto refused = [&](const std::string& faces) { return refusal("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n" + faces); };
    CHECK(refused("3\n0 1 2\n3\n2 1\n") == "line 10, byte 42: expected a vertex number, found the end of the file");
    CHECK(refused("3\n0 1 2\n3\n2 1 3\n").find("line 6, byte ") == 0);
    // As many numbers after the corners of each face, or else they may be corners of the next one.
    CHECK(refused("4 0 1 2\n3 0 2 1\n3 2 1 0\n").find("line 6, byte ") == 0);
    CHECK(refused("3\n0 1 2 1 1 1 1 1\n3 2 1 0\n").find("line 6, byte ") == 0);
}

TEST_CASE("OFF of several pieces gives every vertex and face in order", "[input][off]") {
    std::string text = "OFF\n150000 50001 0\n";
    std::vector<std::array<double, 9>> expected;
    for (int i = 0; i < 50'000; ++i) {
        const std::string x = std::to_string(i);
        text += x + " 0.000000 0.000000\n" + x + " 1.000000 0.000000\n" + x + " 0.000000 1.000000\n";
        const double d = i;
        expected.push_back({d, 0, 0, d, 1, 0, d, 0, 1});
    }
    text += "4 0 1 4 3\n";
    expected.insert(expected.begin(), {{0, 0, 0, 0, 1, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 0, 1, 0, 0}});
    for (int i = 0; i < 150'000; i += 3) {
        text += "3 " + std::to_string(i) + " " + std::to_string(i + 1) + " " + std::to_string(i + 2) + " 0.5 0.5 0.5\n";
    }
    CHECK((read_triangles(dir.write("a.off", text)) == expected));

    const auto path = dir.write("b.off", text + "99999 1 2\nrest\n");
    CHECK((read_triangles(path) == expected));
    CHECK(warnings_of(path) == Texts{"ignored 2 lines after the last of 50001 faces"});

    text.replace(text.find("3 149997 "), 2, "9 ");
    refuses(dir.write("c.off", text), "expected a vertex number, found '0.5'");
}

TEST_CASE("OFF counts that do not fit the text are refused", "[input][off]") {
    const auto refused = [&](const std::string& counts) { return refusal("OFF\n" + counts + "\n" + body()); };
    CHECK_THAT(refused("9 6 0"), Contains("expected 9 vertices and 6 faces, found the end of the file") ||
                                     Contains("expected the end of the line"));
    CHECK_THAT(refused("8 7 0"), Contains("expected 8 vertices and 7 faces, found the end of the file"));
    CHECK_THAT(refused("1000 6 0"), Contains("line 2, byte 4: counts 1000 vertices and 6 faces, more than the "));
    CHECK_THAT(refused("8 4294967296 0"), Contains("line 2, byte 4: counts 8 vertices and 4294967296 faces"));
    CHECK_THAT(refused("99999999999999999999999999 6 0"), Contains("line 2, byte 4: counts "));
    CHECK_THAT(refused("18446744073709551615 18446744073709551615 0"), Contains("line 2, byte 4: counts "));
    CHECK_THAT(refused("-8 6 0"), Contains("line 2, byte 4: expected the number of vertices, found '-8'"));
    CHECK_THAT(refused("8"), Contains("line 3, byte 6: expected the number of faces, found '0.000000'"));
    CHECK_THAT(refused("8 6.0 0"), Contains("line 2, byte 6: expected the number of faces, found '6.0'"));
    CHECK_THAT(refused("8 6 x"), Contains("line 2, byte 8: expected the number of edges, found 'x'"));
    CHECK_THAT(refused("8 6 0 0"), Contains("line 2, byte 10: expected the end of the line, found '0'"));
}

TEST_CASE("impossible OFF faces are refused with line and byte", "[input][off]") {
    const auto refused = [&](const std::string& face) {
        const std::string message = refusal(with_face(face));
        CHECK(message.find("line 6, byte ") == 0);
        return message.substr(8);
    };
    CHECK(refused("3 0 1 3") == "byte 34: vertex number out of range: the file has 3 vertices, found '3'");
    CHECK(refused("3 0 1 99999999999999999999") ==
          "byte 34: vertex number out of range: the file has 3 vertices, found '99999999999999999999'");
    CHECK(refused("3 0 -1 2") == "byte 32: expected a vertex number, found '-1'");
    CHECK(refused("3 0 1 2.5") == "byte 34: expected a vertex number, found '2.5'");
    CHECK(refused("3 0 1    ") == "byte 37: expected a vertex number, found the end of the line");
    CHECK(refused("2 0 3   ") == "byte 32: vertex number out of range: the file has 3 vertices, found '3'");
    CHECK(refused("2") == "byte 28: the face counts 2 corners, more than its line holds");
    CHECK(refused("4294967298 0 1 2") == "byte 28: the face counts 4294967298 corners, more than its line holds");
    CHECK(refused("99999999999999999999 0 1 2").find("more than its line holds") != std::string::npos);
    CHECK(refused("three 0 1 2") == "byte 28: expected the number of a face's corners, found 'three'");
    CHECK(refused("3 0 1 2 red") == "byte 36: expected a number or the end of the line, found 'red'");
    CHECK(refused("3 0 1 2 1 1 1 1 1") == "byte 44: expected the end of the line, found '1'");
}

TEST_CASE("OFF faces of fewer than three corners are left out with a warning", "[input][off]") {
    const std::string head = "OFF\n3 5 0\n0 0 0\n1 0 0\n0 1 0\n";
    const auto path = dir.write("a.off", head + "3 0 1 2\n0\n2 0 1 255 0 0\n3 2 1 0\n1 0\n");
    CHECK((read_triangles(path) ==
           std::vector<std::array<double, 9>>{{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 0, 1, 0, 0, 0, 0, 0}}));
    CHECK(warnings_of(path) == Texts{"left out 3 faces of fewer than three corners, the first in line 7"});
    const auto empty = dir.write("b.off", with_face("2 0 1"));
    CHECK(refuses(empty, "holds no face of three corners or more").code == ErrorCode::empty_mesh);
    CHECK(read_error(dir.write("b.off", "OFF\n0 0 0\n")).code == ErrorCode::empty_mesh);
    CHECK(read_error(dir.write("b.off", "OFF 1 0 0\n1 2 3\n")).code == ErrorCode::empty_mesh);

    const std::string hostile = head + "2 0 1\n3 0 1 2\n0\n30000" + entangled_corners(0) + "\n3 0 1 2\n";
    refuses(dir.write("c.off", hostile), "line 9, byte 44: this face is too entangled");
}

TEST_CASE("OFF may lack its first word where the file's name says what it is", "[input][off]") {
    for (const char* head : {"8 6 0\n", "8 6\n", "# made by hand\n\n 8 6 12 # counts\n",
                             "\xEF\xBB\xBF"
                             "8 6 0\r\n"}) {
        CHECK(hash_of(dir.write("cube.off", head + body())) == cube_hash());
        CHECK(read_mesh(dir / "cube.off")->warnings.empty());
    }
    refuses(dir.write("cube.txt", "8 6 0\n" + body()), "text that begins with '8 6 0'");
    refuses(dir.write("a.off", "8 six\n" + body()), "text that begins with '8 six'");
    refuses(dir.write("b.off", "9 6 0\n" + body()), ": line ");
    CHECK(read_mesh(dir.write("stl.off", ascii_stl(numbered_facets(1))))->format == MeshFormat::stl);
}

TEST_CASE("malformed OFF coordinates are refused with line and byte", "[input][off]") {
    const std::string number = GENERATE(as<std::string>(), "nan", "inf", "1e999", "1,5", "--1", ".", "0x1", "abc");
    const auto path = dir.write("a.off", replaced(with_face("3 0 1 2"), "\n1 0 0", "\n1 " + number + " 0"));
    refuses(path, ": line 4, byte 18: ", "'" + number + "'");
}

TEST_CASE("an OFF file cut anywhere is refused, unless nothing is lost", "[input][off]") {
    refuses_cuts("a.off", cube(), 1, cube().size() - 1);
}

TEST_CASE("binary and 4D OFF are refused as such", "[input][off]") {
    refuses(dir.write("a.off", std::string("OFF BINARY\n\0\0\0\x08", 15)), "is a binary OFF file; only OFF as text is read");
    refuses(dir.write("b.off", "4OFF\n1 1 0\n0 0 0 1\n"), "vertices of other than three coordinates are not read: '4OFF'");
    refuses(dir.write("c.off", "nOFF 3\n1 1 0\n"), "'nOFF'");
    refuses(dir.write("d.off", "OFFICE\n"), "text that begins with 'OFFICE'");
}

}  // namespace lamella::input_test
