#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include <sys/stat.h>
#include <unistd.h>

#include "cpu_time.hpp"
#include "read.hpp"

namespace lamella::input_test {

namespace {

/// The first coordinate of a facet in which it is `number`.
double first_number(const std::string& number) {
    const std::string text = ascii_stl(numbered_facets(1));
    return read_triangles(dir.write("a.stl", replaced(text, "vertex 0.000000 0.000000 0", "vertex " + number + " 0 0")))
        .at(0)[0];
}

}  // namespace

TEST_CASE("text STL is packed into floats, binary STL kept as its bytes", "[input][stl]") {
    const MeshFile text = read_one(dir.write("a.stl", ascii_stl(numbered_facets(7))));
    CHECK(text.text);
    CHECK(text.stride == 36);
    CHECK(text.bytes.size() == 7 * 36);
    const std::vector<Facet> facets = numbered_facets(5);
    const Contents binary = read(dir.write("b.stl", binary_stl(facets, 5, "COLOR=abcd", "\xff\x7f")));
    CHECK(binary.triangles == triangles_of(facets));
    CHECK(binary.warnings.empty());
    CHECK_FALSE(binary.mesh.text);
    CHECK(binary.mesh.stride == 50);
    CHECK(binary.mesh.first_offset == 96);
    CHECK(binary.mesh.bytes.size() == 84 + 5 * 50);
}

TEST_CASE("STL of several pieces gives every facet once, in order, wherever it is cut", "[input][stl][threads]") {
    const std::vector<Facet> facets = numbered_facets(30'000);  // 5 MB
    const std::string text = ascii_stl(facets);
    const std::size_t name = text.find('\n') + 1;
    const auto in_one_line = dir.write("a.stl", text.substr(0, name) + replaced(text.substr(name), "\n", " "));
    CHECK((read_triangles(in_one_line) == triangles_of(facets)));
    const Contents noted = read(dir.write("b.stl", replaced(text, "endfacet\n", "endfacet\n# a facet is above\n")));
    CHECK((noted.triangles == triangles_of(facets)));
    CHECK(noted.warnings == Texts{"ignored 30000 lines between facets, the first in line 9: '#'"});
    const std::vector<Facet> many = numbered_facets(400'000);  // 20 MB
    CHECK((read_triangles(dir.write("c.stl", binary_stl(many))) == triangles_of(many)));
    // Without 'endloop' around the end of the first piece.
    std::string damaged = text;
    for (std::size_t at = text.find("    endloop", 1'048'576 - 300); at < 1'048'576 + 600;
         at = text.find("    endloop", at + 1)) {
        damaged.replace(at, 11, "           ");
    }
    refuses(dir.write("d.stl", damaged), "expected 'endloop' ... found 'endfacet'");
}

TEST_CASE("a solid name of 1 MB is skipped, even one made of keywords", "[input][stl]") {
    const std::string word = GENERATE(as<std::string>(), "x", "facet normal 0 0 1 ", "endfacet facet ", "solid ");
    std::string name;
    while (name.size() < 2'500'000) {  // longer than the pieces in which text is parsed
        name += word;
    }
    const std::vector<Facet> facets = numbered_facets(6);
    const std::string text = ascii_stl({facets.begin(), facets.begin() + 3}, name);
    const auto path = dir.write("a.stl", text + ascii_stl({facets.begin() + 3, facets.end()}, name));
    CHECK(read_triangles(path) == triangles_of(facets));
}

TEST_CASE("numbers of text STL are rounded to the nearest float", "[input][stl]") {
    for (const auto& [text, number] :
         {std::pair("0.1", 0.1F), {"-1.5E+2", -150.0F}, {"+.5", 0.5F}, {"5.", 5.0F}, {"1e-400", 0.0F}, {"3e38", 3e38F}}) {
        CHECK(first_number(text) == number);
    }
    CHECK(std::signbit(first_number("-0")));
    // One past half way between 1 and the next float.
    CHECK(first_number("1.000000059604644775390625" + std::string(5000, '0') + "1") == std::nextafter(1.0F, 2.0F));
    CHECK(first_number("1.000000059604644775390625" + std::string(5000, '0')) == 1.0F);
    CHECK(first_number(std::string(5000, '0') + "7") == 7.0F);
    CHECK(first_number("0." + std::string(20, '0') + std::string(5000, '3')) == Approx(1e-20F / 3).epsilon(1e-6));
}

TEST_CASE("NUL bytes in one long line of text STL take no more time than as many lines", "[input][stl]") {
    std::string name = "solid ";
    for (int i = 0; i < 200'000; ++i) {
        name += std::string("x\0", 2);
    }
    const auto path = dir.write("a.stl", ascii_stl(numbered_facets(2)) + name + "\n");
    const double start = cpu_ms();
    CHECK(read_triangles(path).size() == 2);
    CHECK(cpu_ms() - start < 10000);  // a search back from each takes minutes
}

TEST_CASE("binary STL is read by the count of its header, even if that begins with \"solid\"", "[input][stl]") {
    const std::vector<Facet> facets = numbered_facets(5);
    const std::string header = GENERATE(as<std::string>(), "", "solid part", "SOLID facet normal 0 0 0\n", "solid",
                                        std::string("solid") + std::string(75, ' '));
    CHECK(read_triangles(dir.write("a.stl", binary_stl(facets, 5, header))) == triangles_of(facets));
    for (const std::size_t extra : {1U, 49U, 50U, 1234U}) {
        const Contents more = read(dir.write("a.stl", binary_stl(facets, 5, header) + std::string(extra, 'x')));
        CHECK(more.triangles == triangles_of(facets));
        CHECK_THAT(more.warnings.at(0), Catch::Contains(std::to_string(extra) + (extra == 1 ? " byte " : " bytes ")));
    }
    if (header.find("facet") != std::string::npos) {
        return;  // what is cut off of this one may as well be text
    }
    for (const std::uint32_t counted : {6U, 1U << 24, std::numeric_limits<std::uint32_t>::max()}) {
        const Error error = refuses(dir.write("a.stl", binary_stl(facets, counted, header)),
                                    std::to_string(counted) + " triangles ... has 334");
        CHECK(error.byte_offset == 80);
    }
}

TEST_CASE("a binary STL of no triangles is an empty mesh", "[input][stl]") {
    refuses(dir.write("a.stl", ""), "is empty", ErrorCode::empty_mesh);
    refuses(dir.write("b.stl", binary_stl({})), "", ErrorCode::empty_mesh);
    refuses(dir.write("c.stl", binary_stl(numbered_facets(2), 0)), "0 triangles ... 100 bytes");
}

TEST_CASE("missing files, directories, FIFOs and devices are refused without waiting", "[input]") {
    std::filesystem::create_directory(dir / "directory.stl");
    REQUIRE(::mkfifo((dir / "fifo.stl").c_str(), 0600) == 0);
    refuses(dir / "missing.stl", "No such file", ErrorCode::unreadable_file);
    refuses(dir / "directory.stl", "is a directory", ErrorCode::unreadable_file);
    refuses(dir / "fifo.stl", "is a FIFO", ErrorCode::unreadable_file);
    refuses("/dev/zero", "is a device", ErrorCode::unreadable_file);
    CHECK_THAT(error_of(read_mesh("no\nsuch\tfile.stl")).message, Catch::Contains("no?such?file.stl: "));
}

TEST_CASE("a header of 2^32 - 1 triangles is refused at once", "[input][stl]") {
    const auto path = dir.write("sparse.stl", binary_stl({}, std::numeric_limits<std::uint32_t>::max()));
    std::filesystem::resize_file(path, std::uintmax_t{100} << 30);  // sparse: takes no room
    const auto start = std::chrono::steady_clock::now();
    CHECK(error_of(read_mesh(path)).code == ErrorCode::malformed_mesh);
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(1));
}

}  // namespace lamella::input_test
