#include <cmath>
#include <string>

#include "cpu_time.hpp"
#include "read.hpp"

namespace lamella::input_test {

using Catch::Contains;

namespace {

/// One facet whose first coordinate is `number`.
std::string with_number(const std::string& number) {
    return "solid a\nfacet normal 0 0 1\nouter loop\nvertex " + number +
           " 2 3\nvertex 4 5 6\nvertex 7 8 9\nendloop\nendfacet\nendsolid a\n";
}

float first_number(const std::string& number) {
    return read_facets(dir.write("number.stl", with_number(number))).at(0)[0];
}

}  // namespace

TEST_CASE("ASCII STL is packed into floats", "[input]") {
    const std::vector<Facet> facets = numbered_facets(7);
    const auto path = dir.write("a.stl", ascii_stl(facets));
    CHECK(read_facets(path) == facets);
    const MeshFile mesh = read_one(path);
    CHECK(mesh.text);
    CHECK(mesh.stride == 36);
    CHECK(mesh.bytes.size() == 7 * 36);
}

TEST_CASE("ASCII STL is read in every accepted spelling", "[input]") {
    const std::vector<Facet> facets = numbered_facets(4);
    const std::string plain = ascii_stl(facets, "facet of solid part");
    const std::string name = "facet of solid part";
    const std::string rest = ascii_stl({facets.begin() + 1, facets.end()}, "two facet normal");
    const std::string text = GENERATE_COPY(
        as<std::string>(), replaced(plain, "\n", "\r\n"), replaced(plain, "\n", "\r"), replaced(plain, " ", "\t"),
        replaced(plain, " ", "  \t "), upper(plain), replaced(replaced(plain, "facet", "fAcEt"), "vertex", "Vertex"),
        replaced(plain, "vertex ", "vertex +"), "\xEF\xBB\xBF" + plain, "\n \n" + plain + "\n\n",
        plain.substr(0, plain.find("endsolid")), plain.substr(0, plain.rfind("\nendsolid")), replaced(plain, name, ""),
        replaced(plain, name, "\xC3\xA9t\xC3\xA9"), replaced(plain, "    outer loop\n", "outer loop "),
        "solid one\n" + ascii_facet(facets[0]) + rest);
    INFO(text);
    CHECK(read_facets(dir.write("a.stl", text)) == facets);
}

TEST_CASE("a solid name of 1 MB is skipped, even one made of keywords", "[input]") {
    const std::string word = GENERATE(as<std::string>(), "x", "facet normal 0 0 1 ", "endfacet facet ", "solid ");
    std::string name;
    while (name.size() < 2'500'000) {  // longer than the pieces in which text is parsed
        name += word;
    }
    const std::vector<Facet> facets = numbered_facets(6);
    const std::string text = ascii_stl({facets.begin(), facets.begin() + 3}, name);
    CHECK(read_facets(dir.write("a.stl", text + ascii_stl({facets.begin() + 3, facets.end()}, name))) == facets);
}

TEST_CASE("ASCII STL on one line of many pieces gives every facet once, in order", "[input][threads]") {
    const std::vector<Facet> facets = numbered_facets(30'000);  // 5 MB
    const std::string text = ascii_stl(facets);
    const std::size_t name = text.find('\n') + 1;
    CHECK(read_facets(dir.write("a.stl", text.substr(0, name) + replaced(text.substr(name), "\n", " "))) == facets);
}

TEST_CASE("normals of ASCII STL are skipped", "[input]") {
    const std::string normal = GENERATE(as<std::string>(), "0 0 0", "9 -9 1e9", "nan nan nan", "-nan(ind) NaN 0",
                                        "inf -inf 0", "1.#QNAN -1.#IND 0", "+1 .5 -.5e-3");
    const std::string text = "solid a\n" + ascii_facet(numbered_facet(1), normal);
    CHECK(read_facets(dir.write("a.stl", text)) == std::vector<Facet>{numbered_facet(1)});
}

TEST_CASE("numbers of ASCII STL are rounded to the nearest float", "[input]") {
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

TEST_CASE("malformed coordinates of ASCII STL are refused with line and byte", "[input]") {
    const std::string number =
        GENERATE(as<std::string>(), "nan", "NaN", "inf", "-inf", "+infinity", "1e400", "-1e39", "1,5", "1.5f", "1.2.3",
                 "--1", "+-1", "+", "-", ".", "e5", "0x10", "1e", "abc", std::string(5000, '9'));
    const Error error = refuses(dir.write("a.stl", with_number(number)), ": line 4, byte 45: ", "'" + number.substr(0, 32));
    CHECK(error.code == ErrorCode::malformed_mesh);
    CHECK(error.byte_offset == 45);
    CHECK(error.message.size() < 300);
}

TEST_CASE("lines are counted over LF, CRLF and CR", "[input]") {
    const std::string end = GENERATE(as<std::string>(), "\n", "\r\n", "\r");
    const bool mark = GENERATE(false, true);
    const std::string text = (mark ? "\xEF\xBB\xBF" : "") + replaced(with_number("1e400"), "\n", end);
    const auto at = static_cast<std::int64_t>(text.find("1e400"));
    CHECK(refuses(dir.write("a.stl", text), ": line 4, ").byte_offset == at);
}

TEST_CASE("ASCII STL loops of two or four vertices are refused", "[input]") {
    const std::string three = with_number("1");
    const Error two = read_error(dir.write("two.stl", replaced(three, "vertex 7 8 9\n", "")));
    CHECK_THAT(two.message, Contains("line 6, ") && Contains("expected 'vertex'") && Contains("'endloop'"));
    const Error four = read_error(dir.write("four.stl", replaced(three, "endloop", "vertex 1 1 1\nendloop")));
    CHECK_THAT(four.message, Contains("line 7, ") && Contains("expected 'endloop'") && Contains("'vertex'"));
}

TEST_CASE("facets of ASCII STL are read by their vertices, with a warning", "[input]") {
    const std::vector<Facet> facets = numbered_facets(3);
    const std::string good = ascii_stl(facets);
    const auto warning = [&](const std::string& what, const std::string& replacement) {
        const auto path = dir.write("a.stl", replaced(good, what, replacement));
        CHECK(read_facets(path) == facets);
        const std::vector<std::string> all = warnings_of(path);
        REQUIRE(all.size() == 1);
        const std::string start = "read 3 facets by the vertices alone, the first in line ";
        CHECK(all[0].substr(0, start.size()) == start);
        return all[0].substr(start.size());
    };
    CHECK(warning(" normal 0 0 1", "") == "3: expected 'normal' after 'facet', found 'outer'");
    CHECK(warning(" 0 0 1", "") == "3: expected a number of the normal, found 'outer'");
    CHECK(warning(" 0 0 1", " 0 1") == "3: expected a number of the normal, found 'outer'");
    CHECK(warning(" 0 0 1", " 0 0 1 0") == "2: expected 'outer' after the normal, found '0'");
    CHECK(warning(" 0 0 1", " 0,0 0,0 1,0") == "2: expected a number of the normal, found '0,0'");
    CHECK(warning(" 0 0 1", " n/a n/a n/a") == "2: expected a number of the normal, found 'n/a'");
    CHECK(warning("outer loop", "") == "4: expected 'outer' after the normal, found 'vertex'");
    CHECK(warning("outer loop", "colour 1 0 0\nouter loop") == "3: expected 'outer' after the normal, found 'colour'");
    CHECK(warning("endfacet", "") == "9: expected 'endfacet' after 'endloop', found 'facet'");
    CHECK(warning("endloop", "endloop 1 red") == "7: expected 'endfacet' after 'endloop', found '1'");
}

TEST_CASE("lines between the facets of ASCII STL that are no statements are ignored with a warning", "[input]") {
    const std::vector<Facet> facets = numbered_facets(2);
    const std::string good = ascii_stl(facets);
    const auto warnings = [&](const std::string& text) {
        const auto path = dir.write("a.stl", text);
        CHECK(read_facets(path) == facets);
        return warnings_of(path);
    };
    CHECK(warnings(replaced(good, "solid part\n  facet", "solid part\n# of this facet\ncolour 1\n  facet")) ==
          Texts{"ignored 2 lines between facets, the first in line 2: '#'"});
    CHECK(warnings(good + "made by hand") == Texts{"ignored 1 line between facets, the first in line 17: 'made'"});

    const auto refusal = [&](const std::string& text) {
        const Error error = read_error(dir.write("b.stl", text));
        CHECK(error.code == ErrorCode::malformed_mesh);
        return error.message.substr(error.message.find(": line") + 2);
    };
    // Where a facet would be lost.
    CHECK(refusal(replaced(good, "endfacet\n  facet", "endfacet\n  fact")).find("line 9, byte ") == 0);
    CHECK(refusal(replaced(good, "endfacet\n  facet", "endfacet\n  # facet")).find("line 9, byte ") == 0);
    CHECK(refusal(replaced(good, "endfacet\n  facet", "endfacet\n  vertex 1 1 1\n  facet")).find("line 9, byte ") == 0);
}

TEST_CASE("comments that speak of facets do not depend on where ASCII STL is cut into pieces", "[input]") {
    const std::vector<Facet> facets = numbered_facets(30'000);
    const auto path = dir.write("a.stl", replaced(ascii_stl(facets), "endfacet\n", "endfacet\n# a facet is above\n"));
    CHECK(read_facets(path) == facets);
    CHECK(warnings_of(path) == Texts{"ignored 30000 lines between facets, the first in line 9: '#'"});
}

TEST_CASE("NUL bytes of ASCII STL are read as spaces with a warning, and refused within words", "[input]") {
    const std::vector<Facet> facets = numbered_facets(2);
    const std::string good = ascii_stl(facets);
    const std::string nuls(3, '\0');
    const auto warning = [&](const std::string& text) {
        const auto path = dir.write("a.stl", text);
        CHECK(read_facets(path) == facets);
        return warnings_of(path).at(0);
    };
    const std::string start = "is an ASCII STL file with 3 NUL bytes, read as spaces, the first in line ";
    CHECK(warning(replaced(good, "solid part\n  facet", "solid part" + nuls + "\n  facet")) == start + "1");
    CHECK(warning(replaced(good, "endfacet\n  facet", "endfacet\n" + nuls + "  facet")) == start + "9");
    CHECK(warning(good + nuls) == start + "17");
    const std::string long_name = "solid " + std::string(70'000, 'x') + good.substr(10);
    CHECK(warning(long_name + nuls) == start + "17");

    const auto path = dir.write("b.stl", replaced(good, "endfacet\n  facet", "endf" + nuls + "t\n  facet"));
    const char* const says = "a NUL byte within a word of an ASCII STL file: what stood there is lost";
    CHECK(refuses(path, ": line 8, byte ", says).code == ErrorCode::malformed_mesh);
    CHECK_FALSE(read_mesh(dir.write("c.stl", replaced(good, "vertex 0", "vertex 0" + std::string(1, '\0')))).ok());
}

TEST_CASE("NUL bytes in one long line of ASCII STL take no more time than as many lines", "[input]") {
    std::string name = "solid ";
    for (int i = 0; i < 200'000; ++i) {
        name += std::string("x\0", 2);
    }
    const auto path = dir.write("a.stl", ascii_stl(numbered_facets(2)) + name + "\n");
    const double start = cpu_ms();
    CHECK(read_facets(path) == numbered_facets(2));
    CHECK(cpu_ms() - start < 10000);  // a search back from each takes minutes
}

TEST_CASE("ASCII cut within a facet is refused wherever the cut is", "[input]") {
    const std::string whole = ascii_stl(numbered_facets(2));
    const std::size_t begin = whole.find("facet", whole.find("endfacet") + 8);
    const std::size_t end = whole.rfind("endfacet") + 8;
    refuses_cuts("a.stl", whole, begin + 1, end);
    refuses(dir.write("a.stl", whole.substr(0, end - 9)), "the end of the file");
}

TEST_CASE("the first of several errors in ASCII STL is reported on any number of threads", "[input]") {
    std::string text = ascii_stl(numbered_facets(30'000));
    for (const std::size_t near : {4'000'000U, 2'500'000U}) {
        text.replace(text.find("vertex", near), 6, "vortex");
    }
    const auto at = static_cast<std::int64_t>(text.find("vortex"));
    CHECK(refuses(dir.write("a.stl", text), "'vortex'").byte_offset == at);
}

TEST_CASE("a missing 'endloop' near a cut between pieces is reported", "[input]") {
    std::string text = ascii_stl(numbered_facets(30'000));
    const std::size_t near = text.find("    endloop", 1'048'576 - 300);
    for (std::size_t at = near; at < 1'048'576 + 600; at = text.find("    endloop", at + 1)) {
        text.replace(at, 11, "           ");
    }
    refuses(dir.write("a.stl", text), "expected 'endloop'", "found 'endfacet'");
}

TEST_CASE("stray words in ASCII STL are refused", "[input]") {
    refuses(dir.write("a.stl", "solid ground is good\nto stand on\n"), "line 2, ", "found 'to'");
    refuses(dir.write("b.stl", with_number("1") + "vertex"), "found 'vertex'");
    refuses(dir.write("c.stl", with_number("1 1")), "expected 'vertex'");
    refuses(dir.write("f.stl", "solid a\nfacet normal 0 0 " + std::string(900, 'z')), "zzz...'");
}

TEST_CASE("ASCII STL without triangles is an empty mesh", "[input]") {
    CHECK(read_error(dir.write("a.stl", "solid nothing\nendsolid nothing\n")).code == ErrorCode::empty_mesh);
    CHECK(read_error(dir.write("b.stl", "solid")).code == ErrorCode::empty_mesh);
}

TEST_CASE("ASCII that ends without 'endsolid' is read with a warning that names the line", "[input]") {
    const std::vector<Facet> facets = numbered_facets(2);
    const std::string whole = ascii_stl(facets, "part");
    const auto warnings = [&](const std::string& text) {
        CHECK(read_facets(dir.write("a.stl", text)) == facets);
        return warnings_of(dir / "a.stl");
    };
    const auto after_line = [](int line) {
        return Texts{"ends without 'endsolid' after line " + std::to_string(line) + ": what follows may have been cut off"};
    };
    const std::string cut = whole.substr(0, whole.find("endsolid"));
    CHECK(warnings(whole).empty());
    CHECK(warnings(whole.substr(0, whole.find("endsolid") + 8)).empty());
    CHECK(warnings(replaced(cut, "\n", "\r\n") + "\r\n\r\nENDSOLID").empty());
    CHECK(warnings(ascii_stl({facets[0]}) + ascii_facet(facets[1]) + "endsolid").empty());
    CHECK(warnings(cut) == after_line(15));
    CHECK(warnings(replaced(cut, "\n", "\r") + "\r \r") == after_line(15));
    CHECK(warnings(whole + "solid next\n") == after_line(17));
}

TEST_CASE("ASCII all on one line is read: a name ends where a facet begins", "[input]") {
    const std::vector<Facet> facets = numbered_facets(3);
    for (const std::string& text :
         {ascii_stl(facets, ""), ascii_stl(facets, "x"), ascii_stl(facets, "a facet normal to 1 2 3 facet"),
          upper(ascii_stl(facets)), ascii_stl({facets[0]}, "one") + ascii_stl({facets[1], facets[2]}, "two")}) {
        const auto path = dir.write("a.stl", replaced(text, "\n", " "));
        CHECK(warnings_of(path).empty());
        CHECK(read_facets(path) == facets);
    }
    const std::string one_line = replaced(ascii_stl(facets), "\n", " ");
    refuses(dir.write("b.stl", replaced(one_line, "endloop", "end")), "line 1, ", "expected 'endloop'");
    CHECK(read_error(dir.write("c.stl", "solid x facet normal 0 0 1 endsolid")).code == ErrorCode::empty_mesh);
}

}  // namespace lamella::input_test
