// VTP that is cut off, damaged or made to mislead.
#include <string>

#include "vtp_files.hpp"

namespace lamella::vtk_test {

using Catch::Contains;

TEST_CASE("VTP cut off anywhere is refused", "[input][vtp]") {
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary", "raw", "base64");
    const bool zlib = format == "raw" || format == "binary";
    PolyData data;
    data.points = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
    data.polygons = {{0, 1, 2, 3}};
    const std::string whole = Xml{format, zlib}({data});
    // All that is read lies before the end of the appended data.
    const std::size_t complete =
        format == "raw" || format == "base64" ? whole.rfind("</AppendedData") + 14 : whole.rfind('>') + 1;
    refuses_cuts("a.vtp", whole, whole.find("<VTKFile") + 8, complete);
    CHECK(read_triangles(dir.write("a.vtp", whole.substr(0, complete))) == triangles_of(data));
}

TEST_CASE("appended data of VTP that are cut short are refused", "[input][vtp]") {
    const std::string format = GENERATE(as<std::string>(), "raw", "base64");
    const bool zlib = GENERATE(false, true);
    const std::string whole = Xml{format, zlib}({cube()});
    const std::size_t begin = whole.find('_', whole.find("<AppendedData")) + 1;
    const std::size_t end = whole.rfind("\n</AppendedData");
    for (std::size_t length = begin; length < end; ++length) {
        INFO(length);
        const auto path = dir.write("a.vtp", whole.substr(0, length) + whole.substr(end + 1));
        CHECK(error_of(read_mesh(path)).code == ErrorCode::malformed_mesh);
    }
}

TEST_CASE("malformed VTP is refused with the place", "[input][vtp]") {
    const std::string plain = Xml{}({cube()});
    const std::vector<Malformed> cases = {
        {"type=\"PolyData\"", "type=\"UnstructuredGrid\"",
         "line 2, byte 22: expected a file of type PolyData, the only one that is read, found "
         "'UnstructuredGrid'"},
        {"LittleEndian", "MiddleEndian", "expected byte_order LittleEndian or BigEndian, found 'Middle"},
        {"UInt64\"", "UInt16\"", "expected header_type UInt32 or UInt64, found 'UInt16'"},
        {"NumberOfPoints=\"8\"", "NumberOfPoints=\"-8\"", "expected a number as NumberOfPoints, found '-8'"},
        {"NumberOfPoints=\"8\"", "", "expected a Piece with NumberOfPoints"},
        {"NumberOfPoints=\"8\"", "NumberOfPoints=\"9\"", "expected 27 numbers of Points, found 24"},
        {"NumberOfPoints=\"8\"", "NumberOfPoints=\"7\"", "expected the end of the 21 numbers of Points"},
        {"NumberOfPoints=\"8\"", "NumberOfPoints=\"5000000000\"", "expected fewer than 2^32 points"},
        {"NumberOfPolys=\"6\"", "NumberOfPolys=\"18446744073709551615\"", "numbers of offsets of Polys, found 6"},
        {"NumberOfPolys=\"6\"", "NumberOfPolys=\"5\"", "expected the end of the 5 numbers of offsets of Polys"},
        {"NumberOfStrips=\"0\"", "NumberOfStrips=\"1\"", "expected 1 numbers of offsets of Strips, found 0"},
        {"NumberOfComponents=\"3\"", "NumberOfComponents=\"2\"", "expected Points of 3 components"},
        {"Name=\"offsets\"", "Name=\"others\"", "'connectivity' and 'offsets' of the Polys"},
        {"Name=\"offsets\"", "Name=\"connectivity\"", "expected one such DataArray, found a second"},
        {"type=\"Int64\" Name=\"offsets\"", "type=\"Float32\" Name=\"offsets\"", "expected integers, found"},
        {"type=\"Int64\" Name=\"offsets\"", "type=\"String\" Name=\"offsets\"", "found 'String'"},
        {"format=\"ascii\"", "format=\"morse\"", "expected format ascii or binary, found 'morse'"},
        {"<VTKFile", "<VTKFiles", "expected the element VTKFile, found 'VTKFiles'"},
        {"<Points>", "<Point>", "malformed XML: mismatched tag"},
        {"<?xml version=\"1.0\"?>", "<!DOCTYPE a [<!ENTITY b \"c\">]>", "document type"},
        {"0 2 3 1 ", "0 2 8 1 ", "point 8 of Polys does not exist: there are 8"},
        {"0 2 3 1 ", "0 &#50; 3 1 ", "found '&#50;'"},
        {"4 8 12 ", "4 3 12 ", "cell 1 of Polys ends at 3, which is not from 4 to 24"},
        {"4 8 12 ", "4 25 12 ", "cell 1 of Polys ends at 25"},
        {"20 24 ", "20 23 ", "expected the end of the 23 numbers of connectivity of Polys"},
    };
    refuses_each("a.vtp", plain, cases);
    // Decimals are expected, and the element has no text at all.
    const std::size_t offsets = plain.find("Name=\"offsets\" format=\"ascii\"", plain.find("<Polys>"));
    REQUIRE(offsets != std::string::npos);
    const std::size_t text = plain.find('>', offsets);
    const std::size_t closing = plain.find("</DataArray>", text);
    refuses(dir.write("a.vtp", plain.substr(0, text) + "/>" + plain.substr(closing + 12)), "line ",
            "expected 6 numbers of offsets of Polys, found 0");
    CHECK(read_error(dir.write("a.vtp", Xml{}({}))).code == ErrorCode::empty_mesh);
    refuses(dir.write("a.vtp", replaced(plain, "NumberOfPolys=\"6\"", "NumberOfPolys=\"0\"")), "holds no triangles");
}

TEST_CASE("binary VTP arrays with wrong sizes are refused", "[input][vtp]") {
    for (const char* format : {"binary", "raw", "base64"}) {
        Xml xml{format};
        const std::vector<Malformed> cases = {
            {"NumberOfPoints=\"8\"", "NumberOfPoints=\"4294967295\"", "Points should have 51539607540 bytes, but counts 96"},
            {"NumberOfPolys=\"6\"", "NumberOfPolys=\"2305843009213693952\"", "offsets of Polys should have"},
            {"NumberOfPolys=\"6\"", "NumberOfPolys=\"5\"", "but counts 48"},
            {" header_type=\"UInt64\"", "", " should have "},
        };
        refuses_each("a.vtp", xml({cube()}), cases);
        PolyData bad = cube();
        bad.polygons[5][3] = 9;
        refuses(dir.write("a.vtp", xml({bad})), "point 9 of Polys does not exist: there are 8");
    }
    const std::vector<Malformed> of_raw = {
        {" offset=\"", " offset=\"9", "is truncated"},
        {" offset=\"", " offset=\"-", "expected a number as offset"},
        {" _", " ?", "expected '_' at the beginning"},
        {"\"raw\"", "\"hex\"", "expected encoding raw or base64"},
    };
    refuses_each("a.vtp", Xml{"raw"}({cube()}), of_raw);
    refuses_each("a.vtp", Xml{"binary"}({cube()}), {{"AAAA", "AA?A", "is truncated, or malformed base64"}});
    const char* const says = "is compressed by 'vtkLZ4DataCompressor', which is not read: only vtkZLibDataCompressor is";
    refuses_each("a.vtp", Xml{"binary", true}({cube()}), {{"vtkZLib", "vtkLZ4", says}});
}

TEST_CASE("base64 may hold white space and padding anywhere", "[input][vtp]") {
    const std::string plain = Xml{"binary"}({cube()});
    std::string spaced;
    bool data = false;
    for (std::size_t i = 0; i < plain.size(); ++i) {
        data = plain[i] == '>' ? true : (plain[i] == '<' ? false : data);
        spaced += plain[i];
        spaced += data && i % 5 == 0 ? "\n " : "";
    }
    CHECK(read_triangles(dir.write("a.vtp", spaced)) == triangles_of(cube()));
    // Some writers pad the header by itself.
    std::string coordinates;
    for (const auto& point : cube().points) {
        for (const double c : point) {
            coordinates += Encoding{false, false}.as("Float32", c);
        }
    }
    Xml xml{"binary"};
    const std::string joined = base64(xml.header({96}) + coordinates);
    REQUIRE(plain.find(joined) != std::string::npos);
    CHECK(read_triangles(dir.write("a.vtp", replaced(plain, joined, base64(xml.header({96})) + base64(coordinates)))) ==
          triangles_of(cube()));
}

TEST_CASE("compressed VTP blocks with wrong sizes are refused", "[input][vtp]") {
    const Xml xml{"raw", true};
    const std::string plain = Xml{xml}({cube()});
    // The header of the points: two blocks, of 64 and 32 bytes.
    const std::size_t header = plain.find(xml.header({2, 64, 32}));
    REQUIRE(header != std::string::npos);
    const auto with = [&](std::size_t word, std::uint64_t value) {
        std::string file = plain;
        file.replace(header + 8 * word, 8, xml.header({value}));
        return read_error(dir.write("a.vtp", file));
    };
    for (const std::uint64_t value : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{3}, std::uint64_t{1} << 31,
                                      std::uint64_t{1} << 61, ~std::uint64_t{0}}) {
        for (const std::size_t word : {0U, 1U, 2U, 3U, 4U}) {
            INFO(word << " " << value);
            const Error error = with(word, value);
            CHECK(error.code == ErrorCode::malformed_mesh);
            CHECK_THAT(error.message, Contains("Points"));
        }
    }
    CHECK_THAT(with(0, 1U << 31).message, Contains("counts 2147483648 compressed blocks"));
    CHECK_THAT(with(1, 65).message, Contains("should have 96 bytes, which its compressed blocks do not hold"));
    std::string damaged = plain;
    damaged[header + 8 * 5 + 20] ^= 0x55;
    refuses(dir.write("a.vtp", damaged), "its compressed block 0 does not expand");
}

TEST_CASE("VTP that expands enormously is refused before it is unpacked", "[input][vtp]") {
    PolyData data = sheet(150);
    for (auto& cell : data.polygons) {
        cell = {0, 1, 2};
    }
    Xml xml{"raw", true, false, true, "Float32", "Int64", 32768};
    const auto path = dir.write("a.vtp", xml({data}));
    CHECK_THAT(message_beyond(500'000, path), Contains("expands to more than the 500000 bytes that reading it may take"));
    // A count that the compressed bytes cannot hold is not asked of the limit.
    const std::string few = replaced(Xml{"raw", true}({cube()}), "NumberOfPoints=\"8\"", "NumberOfPoints=\"1000000\"");
    CHECK(read_error(dir.write("b.vtp", few)).code == ErrorCode::malformed_mesh);
    std::string pieces;
    for (int i = 0; i < 5000; ++i) {
        pieces += "<Piece NumberOfPoints=\"0\"/>";
    }
    const auto many = dir.write("c.vtp", replaced(Xml{}({cube()}), "<PolyData>", "<PolyData>" + pieces));
    CHECK(read_one(many).triangle_count == 12);
    CHECK_THAT(message_beyond(500'000, many), Contains("expands"));
}

TEST_CASE("compressed integers of 64 bits are held in 32, unless they are larger", "[input][vtp]") {
    const PolyData data = sheet(200);
    const Xml xml{"raw", true, GENERATE(false, true), true, "Float32", "Int64", 32768};
    const auto path = dir.write("a.vtp", Xml{xml}({data}));
    const std::uint64_t limit = 2'300'000;  // 1.9 MB are needed so, and 2.6 otherwise
    const MeshFile mesh = value_of(read_mesh(path, {.memory_limit_bytes = limit}));
    CHECK(triangles_of(mesh) == triangles_of(read_one(dir.write("b.vtp", Xml{}({data})))));
    PolyData large = cube();
    large.polygons[5][3] = 0xFFFFFFFF;
    Xml larger{xml};
    larger.integers = "Int64";
    refuses(dir.write("a.vtp", larger({large})), "point 4294967295 of Polys does not exist: there are 8");
}

TEST_CASE("markup in VTP array text is parsed as XML, and refused with its line", "[input][vtp]") {
    const std::string whole = Xml{}({cube()});
    const std::size_t numbers = whole.find('>', whole.find("connectivity", whole.find("<Polys"))) + 1;
    const auto with = [&](const std::string& more) {
        std::string file = whole;
        file.insert(file.find('<', numbers), more);
        return file;
    };
    CHECK(read_one(dir.write("a.vtp", with(" \t\r\n "))).triangle_count == 12);
    refuses(dir.write("a.vtp", with("<!-- <DataArray> -->")), "found '<!--'");
    const std::size_t lines = static_cast<std::size_t>(
        std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.find('<', numbers)), '\n'));
    const std::string line = "line " + std::to_string(lines + 1) + ",";
    for (const char* const more : {"&", "]]>", "&unknown;", "\x01", "\xFF"}) {
        refuses(dir.write("a.vtp", with(more)), "malformed XML", line);
    }
    refuses(dir.write("a.vtp", with("+")), "found '+");
}

}  // namespace lamella::vtk_test
