// STL that is binary or large. All else: cases/stl.txt.
#include <chrono>
#include <limits>

#include "cpu_time.hpp"
#include "read.hpp"

namespace lamella::input_test {

TEST_CASE("text STL is packed into floats, binary STL kept as its bytes", "[input][stl]") {
    const Soup facets = numbered_facets(5);
    const MeshFile text = read_one(dir.write("a.stl", text_stl(facets)));
    CHECK(text.text);
    CHECK(text.stride == 36);
    CHECK(text.bytes.size() == 5 * 36);
    CHECK(std::signbit(triangles_of(read_one(dir.write("a.stl", replaced(text_stl(facets), " 0.0", " -0.0"))))[0][1]));
    const Contents binary = read(dir.write("b.stl", binary_stl(facets, {.header = "COLOR=abcd", .attribute = "\xff\x7f"})));
    CHECK(binary.triangles == triangles_of(facets));
    CHECK(binary.warnings.empty());
    CHECK_FALSE(binary.mesh.text);
    CHECK(binary.mesh.stride == 50);
    CHECK(binary.mesh.first_offset == 96);
    CHECK(binary.mesh.bytes.size() == 84 + 5 * 50);
}

TEST_CASE("STL of several pieces gives every facet once, in order, wherever it is cut", "[input][stl][threads]") {
    const Soup facets = numbered_facets(30'000);  // 5 MB
    const std::string text = text_stl(facets);
    CHECK((read_triangles(dir.write("a.stl", replaced(text, "\n", " "))) == triangles_of(facets)));
    const Contents noted = read(dir.write("b.stl", replaced(text, "endfacet\n", "endfacet\n# a facet is above\n")));
    CHECK((noted.triangles == triangles_of(facets)));
    CHECK(noted.warnings == Texts{"ignored 30000 lines between facets, the first in line 9: '#'"});
    const Soup many = numbered_facets(400'000);  // 20 MB
    CHECK((read_triangles(dir.write("c.stl", binary_stl(many))) == triangles_of(many)));
    // Without 'endloop' around the end of the first piece.
    constexpr std::size_t begin = 1'048'576 - 300;
    const std::string damaged = text.substr(0, begin) + replaced(text.substr(begin, 900), "endloop\n", "\n");
    refuses(dir.write("d.stl", damaged + text.substr(begin + 900)), "expected 'endloop' ... found 'endfacet'");
}

TEST_CASE("a solid name of 1 MB is skipped, even one made of keywords", "[input][stl]") {
    const std::string word = GENERATE(as<std::string>(), "x", "facet normal 0 0 1 ", "endfacet facet ", "solid ");
    const std::string name = repeated(word, 2'500'000 / word.size());  // longer than the pieces in which text is parsed
    const Soup facets = numbered_facets(3);
    const auto path = dir.write("a.stl", text_stl(facets, name) + text_stl(facets, name));
    CHECK(read_triangles(path) == triangles_of(shapes::joined({facets, facets})));
}

TEST_CASE("NUL bytes in one long line of text STL take no more time than as many lines", "[input][stl]") {
    const std::string name = "solid " + repeated(std::string("x\0", 2), 200'000);
    const auto path = dir.write("a.stl", text_stl(numbered_facets(2)) + name + "\n");
    const double start = cpu_ms();
    CHECK(read_triangles(path).size() == 2);
    CHECK(cpu_ms() - start < 10000);  // a search back from each takes minutes
}

TEST_CASE("binary STL is read by the count of its header, even if that begins with \"solid\"", "[input][stl]") {
    const Soup facets = numbered_facets(5);
    const std::string header = GENERATE(as<std::string>(), "", "solid part", "SOLID facet normal 0 0 0\n", "solid",
                                        std::string("solid") + std::string(75, ' '));
    const std::string bytes = binary_stl(facets, {header});
    CHECK(read_triangles(dir.write("a.stl", bytes)) == triangles_of(facets));
    for (const std::size_t extra : {1U, 49U, 50U, 1234U}) {
        const Contents more = read(dir.write("a.stl", bytes + std::string(extra, 'x')));
        CHECK(more.triangles == triangles_of(facets));
        CHECK_THAT(more.warnings.at(0), Catch::Contains(std::to_string(extra) + (extra == 1 ? " byte " : " bytes ")));
    }
    if (header.find("facet") != std::string::npos) {
        return;  // what is cut off of this one may as well be text
    }
    for (const std::int64_t counted : {std::int64_t{6}, std::int64_t{1} << 24, std::int64_t{0xFFFFFFFF}}) {
        const Error error = refuses(dir.write("a.stl", binary_stl(facets, {header, counted})),
                                    std::to_string(counted) + " triangles ... has 334");
        CHECK(error.byte_offset == 80);
    }
}

TEST_CASE("a binary STL of no triangles is an empty mesh, one of 2^32 - 1 is refused at once", "[input][stl]") {
    refuses(dir.write("a.stl", ""), "is empty", ErrorCode::empty_mesh);
    refuses(dir.write("b.stl", binary_stl({})), "", ErrorCode::empty_mesh);
    refuses(dir.write("c.stl", binary_stl(numbered_facets(2), {"", 0})), "0 triangles ... has 184");
    const auto path = dir.write("sparse.stl", binary_stl({}, {"", std::numeric_limits<std::uint32_t>::max()}));
    std::filesystem::resize_file(path, std::uintmax_t{100} << 30);  // sparse: takes no room
    const auto start = std::chrono::steady_clock::now();
    CHECK(error_of(read_mesh(path)).code == ErrorCode::malformed_mesh);
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(1));
}

}  // namespace lamella::input_test
