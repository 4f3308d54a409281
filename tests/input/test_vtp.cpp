#include <string>

#include "vtp_files.hpp"

namespace lamella::vtk_test {

TEST_CASE("VTP gives the same triangles however its arrays are stored", "[input][vtp]") {
    // The last are triangles alone, which are read another way.
    const std::vector<PolyData> pieces =
        GENERATE(std::vector<PolyData>{cube_with_strip()}, std::vector<PolyData>{cube(3), {}, cube_with_strip(), sheet(90)},
                 std::vector<PolyData>{triangle(3), {}, triangle(5)});
    Triangles expected;
    for (const PolyData& piece : pieces) {
        const Triangles triangles = triangles_of(piece);
        expected.insert(expected.end(), triangles.begin(), triangles.end());
    }
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary", "raw", "base64");
    for (const bool zlib : {false, true}) {
        for (const bool big_endian : {false, true}) {
            for (const bool wide : {false, true}) {
                Xml xml{format, zlib && format != "ascii", big_endian, wide};
                xml.block = pieces.size() == 1 ? 64 : 32768;
                CHECK(read_triangles(dir.write("a.vtp", xml(pieces))) == expected);
            }
        }
    }
    const Contents contents = read(dir.write("a.vtp", Xml{format}(pieces)));
    CHECK(contents.mesh.text == (format == "ascii"));
    CHECK(contents.warnings.empty());
}

TEST_CASE("VTP takes arrays of every type", "[input][vtp]") {
    const PolyData data = cube_with_strip();
    const std::string format = GENERATE(as<std::string>(), "ascii", "raw", "base64");
    const bool big_endian = GENERATE(false, true);
    for (const char* type : {"Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"}) {
        Xml xml{format, false, big_endian, true, type, type};
        CHECK(read_triangles(dir.write("a.vtp", xml({data}))) == triangles_of(data));
    }
    Xml xml{format, false, big_endian, true, "Float64"};
    const Contents contents = read(dir.write("a.vtp", xml({data})));
    CHECK(contents.triangles == triangles_of(data));
    CHECK(contents.mesh.vertex_type == Number::f64);
}

TEST_CASE("field data of VTP may state the patient frame", "[input][vtp]") {
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary");
    const auto frame = [&](const std::string& name, const std::string& bytes) {
        Xml xml{format};
        std::string codes;
        for (const char c : bytes) {
            codes += xml.text() ? std::to_string(int{c}) + " " : std::string(1, c);
        }
        xml.field = xml.element("type=\"String\" Name=\"" + name + "\" NumberOfTuples=\"1\"", codes);
        xml.field = "<FieldData>" + replaced(xml.field, "DataArray", "Array") + "</FieldData>";
        return read_one(dir.write("a.vtp", xml({cube()}))).patient_frame;
    };
    CHECK(frame("SPACE", std::string("LPS\0", 4)) == PatientFrame::lps);
    CHECK(frame("SPACE", std::string("RAS\0", 4)) == PatientFrame::ras);
    CHECK(frame("OTHER", std::string("LPS\0", 4)) == PatientFrame::unstated);
    for (const std::string value : {"LPSX", "lps", "left-posterior-superior"}) {
        CHECK(frame("SPACE", value) == PatientFrame::unstated);
    }
}

TEST_CASE("VTP and its appended data cut off anywhere are refused", "[input][vtp]") {
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary", "raw", "base64");
    const bool zlib = format == "raw" || format == "binary";
    PolyData data;
    data.points = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
    data.polygons = {{0, 1, 2, 3}};
    const std::string whole = Xml{format, zlib}({data});
    const std::size_t appended = whole.rfind("</AppendedData");
    // All that is read lies before the end of the appended data.
    const std::size_t complete = appended != std::string::npos ? appended + 14 : whole.rfind('>') + 1;
    refuses_cuts("a.vtp", whole, whole.find("<VTKFile") + 8, complete);
    CHECK(read_triangles(dir.write("a.vtp", whole.substr(0, complete))) == triangles_of(data));
    for (const bool packed : {false, true}) {
        const std::string file = Xml{format, packed}({cube()});
        const std::size_t end = file.rfind("\n</AppendedData");
        const std::size_t begin = file.find('_', file.find("<AppendedData")) + 1;
        for (std::size_t length = begin; end != std::string::npos && length < end; ++length) {
            INFO(length);
            const auto path = dir.write("a.vtp", file.substr(0, length) + file.substr(end + 1));
            CHECK(error_of(read_mesh(path)).code == ErrorCode::malformed_mesh);
        }
    }
}

TEST_CASE("binary VTP arrays with wrong sizes are refused", "[input][vtp]") {
    for (const char* format : {"binary", "raw", "base64"}) {
        Xml xml{format};
        refuses_each("a.vtp", xml({cube()}),
                     {{"NumberOfPoints=\"8\"", "NumberOfPoints=\"4294967295\"",
                       "Points should have 51539607540 bytes, but counts 96"},
                      {"NumberOfPolys=\"6\"", "NumberOfPolys=\"2305843009213693952\"", "offsets of Polys should have"},
                      {"NumberOfPolys=\"6\"", "NumberOfPolys=\"5\"", "but counts 48"},
                      {" header_type=\"UInt64\"", "", " should have "}});
        PolyData bad = cube();
        bad.polygons[5][3] = 9;
        refuses(dir.write("a.vtp", xml({bad})), "point 9 of Polys does not exist: there are 8");
    }
    refuses_each("a.vtp", Xml{"raw"}({cube()}),
                 {{" offset=\"", " offset=\"9", "is truncated"},
                  {" offset=\"", " offset=\"-", "expected a number as offset"},
                  {" _", " ?", "expected '_' at the beginning"},
                  {"\"raw\"", "\"hex\"", "expected encoding raw or base64"}});
    refuses_each("a.vtp", Xml{"binary"}({cube()}), {{"AAAA", "AA?A", "is truncated, or malformed base64"}});
    const char* const says = "is compressed by 'vtkLZ4DataCompressor', which is not read: only vtkZLibDataCompressor is";
    refuses_each("a.vtp", Xml{"binary", true}({cube()}), {{"vtkZLib", "vtkLZ4", says}});
}

TEST_CASE("base64 may hold white space and padding anywhere", "[input][vtp]") {
    Xml xml{"binary"};
    const std::string plain = xml({cube()});
    std::string spaced;
    bool data = false;
    for (std::size_t i = 0; i < plain.size(); ++i) {
        data = plain[i] == '>' || (data && plain[i] != '<');
        spaced += plain[i];
        spaced += data && i % 5 == 0 ? "\n " : "";
    }
    CHECK(read_triangles(dir.write("a.vtp", spaced)) == triangles_of(cube()));
    // Some writers pad the header by itself.
    std::string coordinates;
    for (const double c : cube().coordinates()) {
        coordinates += Encoding{false, false}.as("Float32", c);
    }
    const std::string joined = base64(xml.header({96}) + coordinates);
    REQUIRE(plain.find(joined) != std::string::npos);
    const std::string apart = replaced(plain, joined, base64(xml.header({96})) + base64(coordinates));
    CHECK(read_triangles(dir.write("a.vtp", apart)) == triangles_of(cube()));
}

TEST_CASE("compressed VTP blocks with wrong sizes are refused", "[input][vtp]") {
    const Xml xml{"raw", true};
    const std::string plain = Xml{xml}({cube()});
    // The header of the points: two blocks, of 64 and 32 bytes.
    const std::size_t header = plain.find(xml.header({2, 64, 32}));
    REQUIRE(header != std::string::npos);
    const auto refused = [&](std::size_t word, std::uint64_t value, const std::string& says) {
        INFO(word << " " << value);
        std::string file = plain;
        refuses(dir.write("a.vtp", file.replace(header + 8 * word, 8, xml.header({value}))), says);
    };
    for (const std::uint64_t value : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{3}, std::uint64_t{1} << 31,
                                      std::uint64_t{1} << 61, ~std::uint64_t{0}}) {
        for (std::size_t word = 0; word < 5; ++word) {
            refused(word, value, "Points");
        }
    }
    refused(0, 1U << 31, "counts 2147483648 compressed blocks");
    refused(1, 65, "should have 96 bytes, which its compressed blocks do not hold");
    std::string damaged = plain;
    damaged[header + 8 * 5 + 20] ^= 0x55;
    refuses(dir.write("a.vtp", damaged), "its compressed block 0 does not expand");
    // A count that the compressed bytes cannot hold is not asked of the limit.
    refuses(dir.write("b.vtp", replaced(plain, "NumberOfPoints=\"8\"", "NumberOfPoints=\"1000000\"")), "");
}

TEST_CASE("compressed integers of 64 bits are held in 32, unless they are larger", "[input][vtp]") {
    const PolyData data = sheet(200);
    Xml xml{"raw", true, GENERATE(false, true)};
    xml.block = 32768;
    const auto path = dir.write("a.vtp", xml({data}));
    const std::uint64_t limit = 2'300'000;  // 1.9 MB are needed so, and 2.6 otherwise
    CHECK((triangles_of(value_of(read_mesh(path, {.memory_limit_bytes = limit}))) == triangles_of(data)));
    PolyData large = cube();
    large.polygons[5][3] = 0xFFFFFFFF;
    refuses(dir.write("a.vtp", xml({large})), "point 4294967295 of Polys does not exist: there are 8");
}

}  // namespace lamella::vtk_test
