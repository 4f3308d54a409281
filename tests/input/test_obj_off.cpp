// OBJ and OFF that are large, or known by name alone. All else: cases/obj.txt and cases/off.txt.
#include "read.hpp"

namespace lamella::input_test {

namespace {

/// Three vertices, then `faces`.
std::string obj_of(const std::string& faces) {
    return "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + faces + "\n";
}

/// A polygon of 30,000 random corners of three, whose first is `first`: it crosses itself too often to be cut.
std::string entangled_corners(std::uint32_t first) {
    std::string text;
    for (std::uint32_t i = 0, random = 1; i < 30'000; ++i) {
        random = random * 1'664'525 + 1'013'904'223;
        text += " " + std::to_string((random >> 16) % 3 + first);
    }
    return text;
}

}  // namespace

TEST_CASE("a relative OBJ reference counts back from its own line", "[input][obj]") {
    std::string text;
    Triangles expected;
    for (int i = 0; i < 70'000; ++i) {  // 3 MB: several pieces
        const std::string x = std::to_string(i);
        text += "v " + x + " 0 0\nv " + x + " 1 0\nv " + x + " 0 1\nf -3 -2 -1\n";
        const double d = i;
        expected.push_back({d, 0, 0, d, 1, 0, d, 0, 1});
    }
    CHECK((read_triangles(dir.write("a.obj", text)) == expected));
}

TEST_CASE("pieces of OBJ text end neither within a statement nor within a comment", "[input][obj][threads]") {
#ifdef LAMELLA_TESTS_SANITIZED
    const std::string end = "\r\n";
#else
    const std::string end = GENERATE(as<std::string>(), "\n", "\r\n", "\r");
#endif
    std::string face = "f";
    for (std::size_t i = 0; i < 500'000; ++i) {  // one face on half a million lines
        face += " " + std::to_string(i % 3 + 1) + "\\\n";
    }
    CHECK(read_triangles(dir.write("a.obj", replaced(obj_of(face + " 1\nf 1 2 3"), "\n", end))).size() == 500'000);
    const std::string far = repeated("vn 0 0 1\n", end == "\r" ? 100 : 300'000);  // the other ends are long enough
    const std::string line = end == "\r" ? "105" : "300005";
    const std::string statements = replaced(obj_of("f 1 2 3\n" + far + "what\n" + far + "what"), "\n", end);
    CHECK(warnings_of(dir.write("b.obj", statements)) ==
          Texts{"ignored 2 statements that are not read, the first in line " + line + ": 'what'"});
}

TEST_CASE("hostile faces of OBJ and OFF are refused with their line", "[input][obj][off]") {
    const std::string face = "f" + entangled_corners(1);
    refuses(dir.write("a.obj", obj_of("f 1 2 3\n" + face)), "line 5, byte 32: this face is too entangled");
    refuses(dir.write("b.obj", obj_of("f 1 2\nf 1 2 3\nf 2 \\\n 3\n" + face)),
            "line 8, byte 47: this face is too entangled");
    const std::string off =
        "OFF\n3 5 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n0\n30000" + entangled_corners(0) + "\n3 0 1 2\n";
    refuses(dir.write("c.off", off), "line 9, byte 44: this face is too entangled");
}

TEST_CASE("OBJ and OFF without their first words are known by the file's name", "[input][obj][off]") {
    for (const char* head : {"", "# a\n", "mtllib a.mtl\n", "g part\n", "vn 0 0 1\n"}) {
        CHECK(read_one(dir.write("a", head + obj_of("f 1 2 3"))).format == MeshFormat::obj);
    }
    const std::string prose = "Exported by hand\n\n" + obj_of("f 1 2 3");
    CHECK(warnings_of(dir.write("a.obj", prose)) ==
          Texts{"ignored 1 statement that is not read, the first in line 1: 'Exported'"});
    CHECK_FALSE(read_mesh(dir.write("a.txt", prose)).ok());
    CHECK_FALSE(read_mesh(dir.write("b.obj", "vase and flowers\nvery nice\n")).ok());
    refuses(dir.write("a.txt", "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "text that begins with '3 1 0'");
    CHECK(read_mesh(dir.write("stl.off", text_stl(numbered_facets(1)))).value().format == MeshFormat::stl);
}

}  // namespace lamella::input_test
