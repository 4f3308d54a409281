#include <string>

#include <catch2/catch.hpp>

#include "read.hpp"
#include "vtk_files.hpp"

namespace lamella::vtk_test {

using Catch::Contains;

namespace {

std::string base64(const std::string& bytes) {
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += i + k > bytes.size() ? '=' : alphabet[bits >> (18 - 6 * k) & 63];
        }
    }
    return text;
}

std::string zipped(const std::string& bytes) {
    std::string packed(compressBound(bytes.size()), '\0');
    uLongf size = packed.size();
    REQUIRE(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                     bytes.size()) == Z_OK);
    packed.resize(size);
    return packed;
}

/// Writes files whose arrays are all stored in one way.
struct Xml {
    std::string format = "ascii";  ///< or "binary", or "raw" or "base64" for those that are appended
    bool zlib = false;
    bool big_endian = false;
    bool wide = true;  ///< headers of 64 bits
    std::string points = "Float32";
    std::string integers = "Int64";
    std::size_t block = 64;
    std::string field{};     ///< before the pieces
    std::string appended{};  ///< what has been appended so far

    bool text() const { return format == "ascii"; }

    std::string header(const std::vector<std::uint64_t>& numbers) const {
        std::string bytes;
        for (const std::uint64_t number : numbers) {
            bytes += Encoding{false, big_endian}.as(wide ? "UInt64" : "UInt32", number);
        }
        return bytes;
    }

    std::string stored(const std::string& data) const {
        std::string head;
        std::string body = data;
        if (zlib) {
            std::vector<std::uint64_t> counts{(data.size() + block - 1) / block, block, data.size() % block};
            body.clear();
            for (std::size_t at = 0; at < data.size(); at += block) {
                const std::string packed = zipped(data.substr(at, block));
                counts.push_back(packed.size());
                body += packed;
            }
            head = header(counts);
            return format == "raw" ? head + body : base64(head) + base64(body);
        }
        head = header({data.size()});
        return format == "raw" ? head + body : base64(head + body);
    }

    std::string element(const std::string& attributes, const std::string& data) {
        std::string start = "<DataArray " + attributes + " format=\"";
        if (text() || format == "binary") {
            return start + format + "\">\n" + (text() ? data : stored(data)) + "\n</DataArray>\n";
        }
        start += "appended\" offset=\"" + std::to_string(appended.size()) + "\"><InformationKey name=\"a\"/></DataArray>\n";
        appended += stored(data);
        return start;
    }

    std::string array(const std::string& name, const std::string& type, const std::vector<double>& values) {
        std::string data;
        for (const double value : values) {
            data += Encoding{text(), big_endian}.as(type, value);
        }
        return element("type=\"" + type + "\" Name=\"" + name + "\"" + (name == "Points" ? " NumberOfComponents=\"3\"" : ""),
                       data);
    }

    std::string cells(const std::string& name, const Cells& cells) {
        std::vector<double> offsets;
        std::vector<double> corners;
        for (const auto& cell : cells) {
            corners.insert(corners.end(), cell.begin(), cell.end());
            offsets.push_back(static_cast<double>(corners.size()));
        }
        std::string xml = "<" + name + ">\n" + array("connectivity", integers, corners);
        xml += array("offsets", integers, offsets);
        return xml + "</" + name + ">\n";
    }

    std::string piece(const PolyData& data) {
        std::vector<double> coordinates;
        for (const auto& point : data.points) {
            coordinates.insert(coordinates.end(), point.begin(), point.end());
        }
        std::string xml = "<Piece NumberOfPoints=\"" + std::to_string(data.points.size()) + "\" NumberOfStrips=\"" +
                          std::to_string(data.strips.size()) + "\" NumberOfPolys=\"" + std::to_string(data.polygons.size()) +
                          "\">\n";
        // One by one: each array is appended as it is made.
        xml += "<PointData>" + array("Points", "Float32", {1, 2, 3, 4}) + "</PointData>\n";
        xml += "<Points>" + array("Points", points, coordinates) + "</Points>\n";
        xml += "<Verts>" + array("connectivity", "Int64", {}) + "</Verts>\n";
        xml += cells("Strips", data.strips);
        xml += cells("Polys", data.polygons);
        return xml + "</Piece>\n";
    }

    std::string operator()(const std::vector<PolyData>& pieces) {
        appended.clear();
        std::string file = std::string("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"") +
                           (big_endian ? "BigEndian" : "LittleEndian") + "\"" + (wide ? " header_type=\"UInt64\"" : "") +
                           (zlib ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n<PolyData>\n" + field;
        for (const PolyData& data : pieces) {
            file += piece(data);
        }
        file += "</PolyData>\n";
        if (format == "raw" || format == "base64") {
            file += "<AppendedData encoding=\"" + format + "\">\n _" + appended + "\n</AppendedData>\n";
        }
        return file + "</VTKFile>\n";
    }
};

}  // namespace

TEST_CASE("VTP gives the same triangles however its arrays are stored", "[input][vtp]") {
    const TempFolder dir;
    const PolyData data = cube_with_strip();
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary", "raw", "base64");
    for (const bool zlib : {false, true}) {
        for (const bool big_endian : {false, true}) {
            for (const bool wide : {false, true}) {
                Xml xml{format, zlib && format != "ascii", big_endian, wide};
                CHECK(read_triangles(dir.write("a.vtp", xml({data}))) == triangles_of(data));
            }
        }
    }
    const MeshFile mesh = read_one(dir.write("a.vtp", Xml{format}({data})));
    CHECK(mesh.format == MeshFormat::vtp);
    CHECK(mesh.text == (format == "ascii"));
    CHECK(mesh.vertex_count == 8);
    CHECK(mesh.warnings.empty());
}

TEST_CASE("VTP takes arrays of every type", "[input][vtp]") {
    const TempFolder dir;
    const PolyData data = cube_with_strip();
    for (const char* format : {"ascii", "raw", "base64"}) {
        for (const bool big_endian : {false, true}) {
            for (const char* type : {"Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"}) {
                Xml xml{format, false, big_endian, true, type, type};
                CHECK(read_triangles(dir.write("a.vtp", xml({data}))) == triangles_of(data));
            }
            Xml xml{format, false, big_endian, true, "Float64"};
            const auto path = dir.write("a.vtp", xml({data}));
            CHECK(read_triangles(path) == triangles_of(data));
            CHECK(read_one(path).coordinate_type == CoordinateType::f64);
        }
    }
}

TEST_CASE("all pieces of VTP are read, one after the other", "[input][vtp]") {
    const TempFolder dir;
    // The second are triangles alone, which are read another way.
    const std::vector<PolyData> pieces = GENERATE(std::vector<PolyData>{cube(3), {}, cube_with_strip(), sheet(90)},
                                                  std::vector<PolyData>{cube_of_triangles(3), {}, cube_of_triangles(5)});
    std::vector<Facet> expected;
    for (const PolyData& piece : pieces) {
        const std::vector<Facet> facets = triangles_of(piece);
        expected.insert(expected.end(), facets.begin(), facets.end());
    }
    for (const char* format : {"ascii", "binary", "raw", "base64"}) {
        for (const bool zlib : {false, true}) {
            Xml xml{format, zlib && std::string(format) != "ascii", false, true, "Float32", "Int32", 32768};
            CHECK(read_triangles(dir.write("a.vtp", xml(pieces))) == expected);
        }
    }
}

TEST_CASE("VTP is recognised by its content", "[input][vtp]") {
    const TempFolder dir;
    const std::string plain = Xml{}({cube()});
    CHECK(read_triangles(dir.write("a", plain)) == triangles_of(cube()));
    CHECK(read_triangles(dir.write("a.vtp", "\xEF\xBB\xBF" + plain)) == triangles_of(cube()));
    CHECK(read_triangles(dir.write("a.vtp", plain.substr(plain.find("<VTKFile")))) == triangles_of(cube()));
    CHECK(read_triangles(dir.write("a.vtp", replaced(plain, "\n", "\r\n"))) == triangles_of(cube()));
    CHECK(read_triangles(dir.write("a.vtp", replaced(plain, "<PolyData>", "<!-- <AppendedData> -->\n<PolyData>"))) ==
          triangles_of(cube()));
    CHECK(read_one(dir.write("a.vtk", plain)).warnings.size() == 1);
}

TEST_CASE("a cube is sliced the same from STL and VTP", "[input][vtp]") {
    const TempFolder dir;
    const std::uint64_t expected = hash_of(dir.write("a.stl", binary_stl(triangles_of(cube()))));
    for (const char* format : {"ascii", "binary", "raw", "base64"}) {
        CHECK(hash_of(dir.write("a.vtp", Xml{format}({cube()}))) == expected);
    }
}

TEST_CASE("field data of VTP may state the patient frame", "[input][vtp]") {
    const TempFolder dir;
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary");
    const auto frame = [&](const std::string& name, const std::string& value, bool ended = true) {
        Xml xml{format};
        std::string codes = ended ? value + '\0' : value;
        if (xml.text()) {
            codes.clear();
            for (const char c : std::string(ended ? value + '\0' : value)) {
                codes += std::to_string(int{c}) + " ";
            }
        }
        xml.field = xml.element("type=\"String\" Name=\"" + name + "\" NumberOfTuples=\"1\"", codes);
        xml.field = "<FieldData>" + replaced(xml.field, "DataArray", "Array") + "</FieldData>";
        return read_one(dir.write("a.vtp", xml({cube()}))).patient_frame;
    };
    CHECK(frame("SPACE", "LPS") == PatientFrame::lps);
    CHECK(frame("SPACE", "RAS") == PatientFrame::ras);
    CHECK(frame("SPACE", "LPSX", false) == PatientFrame::unstated);
    CHECK(frame("SPACE", "lps") == PatientFrame::unstated);
    CHECK(frame("SPACE", "left-posterior-superior") == PatientFrame::unstated);
    CHECK(frame("OTHER", "LPS") == PatientFrame::unstated);
}

TEST_CASE("VTP cut off anywhere is refused", "[input][vtp]") {
    const TempFolder dir;
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary", "raw", "base64");
    const bool zlib = format == "raw" || format == "binary";
    PolyData data;
    data.points = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
    data.polygons = {{0, 1, 2, 3}};
    const std::string whole = Xml{format, zlib}({data});
    // All that is read lies before the end of the appended data.
    const std::size_t complete =
        format == "raw" || format == "base64" ? whole.rfind("</AppendedData") + 14 : whole.rfind('>') + 1;
    for (std::size_t length = whole.find("<VTKFile") + 8; length < complete; ++length) {
        INFO(length);
        const Result<MeshFile> mesh = read_mesh(dir.write("a.vtp", whole.substr(0, length)));
        REQUIRE_FALSE(mesh.ok());
        CHECK(mesh.error().code == ErrorCode::malformed_mesh);
    }
    CHECK(read_triangles(dir.write("a.vtp", whole.substr(0, complete))) == triangles_of(data));
}

TEST_CASE("appended data of VTP that are cut short are refused", "[input][vtp]") {
    const TempFolder dir;
    const std::string format = GENERATE(as<std::string>(), "raw", "base64");
    const bool zlib = GENERATE(false, true);
    const std::string whole = Xml{format, zlib}({cube()});
    const std::size_t begin = whole.find('_', whole.find("<AppendedData")) + 1;
    const std::size_t end = whole.rfind("\n</AppendedData");
    for (std::size_t length = begin; length < end; ++length) {
        INFO(length);
        const Result<MeshFile> mesh = read_mesh(dir.write("a.vtp", whole.substr(0, length) + whole.substr(end + 1)));
        REQUIRE_FALSE(mesh.ok());
        CHECK(mesh.error().code == ErrorCode::malformed_mesh);
    }
}

TEST_CASE("malformed VTP is refused with the place", "[input][vtp]") {
    const TempFolder dir;
    const auto complaint = [&](const std::string& file) { return read_error(dir.write("a.vtp", file)).message; };
    const std::string plain = Xml{}({cube()});
    const auto with = [&](const std::string& what, const std::string& by) {
        REQUIRE(plain.find(what) != std::string::npos);
        return complaint(replaced(plain, what, by));
    };
    CHECK_THAT(with("type=\"PolyData\"", "type=\"UnstructuredGrid\""),
               Contains("line 2, byte 22: expected a file of type PolyData, the only one that is read, found "
                        "'UnstructuredGrid'"));
    CHECK_THAT(with("LittleEndian", "MiddleEndian"),
               Contains("expected byte_order LittleEndian or BigEndian, found 'Middle"));
    CHECK_THAT(with("UInt64\"", "UInt16\""), Contains("expected header_type UInt32 or UInt64, found 'UInt16'"));
    CHECK_THAT(with("NumberOfPoints=\"8\"", "NumberOfPoints=\"-8\""),
               Contains("expected a number as NumberOfPoints, found '-8'"));
    CHECK_THAT(with("NumberOfPoints=\"8\"", ""), Contains("expected a Piece with NumberOfPoints"));
    CHECK_THAT(with("NumberOfPoints=\"8\"", "NumberOfPoints=\"9\""), Contains("expected 27 numbers of Points, found 24"));
    CHECK_THAT(with("NumberOfPoints=\"8\"", "NumberOfPoints=\"7\""),
               Contains("expected the end of the 21 numbers of Points"));
    CHECK_THAT(with("NumberOfPoints=\"8\"", "NumberOfPoints=\"5000000000\""), Contains("expected fewer than 2^32 points"));
    CHECK_THAT(with("NumberOfPolys=\"6\"", "NumberOfPolys=\"18446744073709551615\""),
               Contains("numbers of offsets of Polys, found 6"));
    CHECK_THAT(with("NumberOfPolys=\"6\"", "NumberOfPolys=\"5\""),
               Contains("expected the end of the 5 numbers of offsets of Polys"));
    CHECK_THAT(with("NumberOfStrips=\"0\"", "NumberOfStrips=\"1\""),
               Contains("expected 1 numbers of offsets of Strips, found 0"));
    CHECK_THAT(with("NumberOfComponents=\"3\"", "NumberOfComponents=\"2\""), Contains("expected Points of 3 components"));
    CHECK_THAT(with("Name=\"offsets\"", "Name=\"others\""), Contains("'connectivity' and 'offsets' of the Polys"));
    CHECK_THAT(with("Name=\"offsets\"", "Name=\"connectivity\""), Contains("expected one such DataArray, found a second"));
    CHECK_THAT(with("type=\"Int64\" Name=\"offsets\"", "type=\"Float32\" Name=\"offsets\""),
               Contains("expected integers, found"));
    CHECK_THAT(with("type=\"Int64\" Name=\"offsets\"", "type=\"String\" Name=\"offsets\""), Contains("found 'String'"));
    CHECK_THAT(with("format=\"ascii\"", "format=\"morse\""), Contains("expected format ascii or binary, found 'morse'"));
    CHECK_THAT(with("<VTKFile", "<VTKFiles"), Contains("expected the element VTKFile, found 'VTKFiles'"));
    CHECK_THAT(with("<Points>", "<Point>"), Contains("malformed XML: mismatched tag"));
    CHECK_THAT(with("<?xml version=\"1.0\"?>", "<!DOCTYPE a [<!ENTITY b \"c\">]>"), Contains("document type"));
    CHECK_THAT(with("0 2 3 1 ", "0 2 8 1 "), Contains("point 8 of Polys does not exist: there are 8"));
    CHECK_THAT(with("0 2 3 1 ", "0 &#50; 3 1 "), Contains("found '&#50;'"));
    CHECK_THAT(with("4 8 12 ", "4 3 12 "), Contains("cell 1 of Polys ends at 3, which is not from 4 to 24"));
    CHECK_THAT(with("4 8 12 ", "4 25 12 "), Contains("cell 1 of Polys ends at 25"));
    CHECK_THAT(with("20 24 ", "20 23 "), Contains("expected the end of the 23 numbers of connectivity of Polys"));
    // Decimals are expected, and the element has no text at all.
    const std::size_t offsets = plain.find("Name=\"offsets\" format=\"ascii\"", plain.find("<Polys>"));
    REQUIRE(offsets != std::string::npos);
    const std::size_t text = plain.find('>', offsets);
    const std::size_t closing = plain.find("</DataArray>", text);
    CHECK_THAT(complaint(plain.substr(0, text) + "/>" + plain.substr(closing + 12)),
               Contains("line ") && Contains("expected 6 numbers of offsets of Polys, found 0"));
    CHECK(read_error(dir.write("a.vtp", Xml{}({}))).code == ErrorCode::empty_mesh);
    CHECK_THAT(with("NumberOfPolys=\"6\"", "NumberOfPolys=\"0\""), Contains("holds no triangles"));
}

TEST_CASE("binary VTP arrays with wrong sizes are refused", "[input][vtp]") {
    const TempFolder dir;
    const auto complaint = [&](const std::string& file) { return read_error(dir.write("a.vtp", file)).message; };
    for (const char* format : {"binary", "raw", "base64"}) {
        Xml xml{format};
        const std::string plain = xml({cube()});
        CHECK_THAT(complaint(replaced(plain, "NumberOfPoints=\"8\"", "NumberOfPoints=\"4294967295\"")),
                   Contains("Points should have 51539607540 bytes, but counts 96"));
        CHECK_THAT(complaint(replaced(plain, "NumberOfPolys=\"6\"", "NumberOfPolys=\"2305843009213693952\"")),
                   Contains("offsets of Polys should have"));
        CHECK_THAT(complaint(replaced(plain, "NumberOfPolys=\"6\"", "NumberOfPolys=\"5\"")), Contains("but counts 48"));
        CHECK_THAT(complaint(replaced(plain, " header_type=\"UInt64\"", "")), Contains(" should have "));
        PolyData bad = cube();
        bad.polygons[5][3] = 9;
        CHECK_THAT(complaint(xml({bad})), Contains("point 9 of Polys does not exist: there are 8"));
    }
    CHECK_THAT(complaint(replaced(Xml{"raw"}({cube()}), " offset=\"", " offset=\"9")), Contains("is truncated"));
    CHECK_THAT(complaint(replaced(Xml{"raw"}({cube()}), " offset=\"", " offset=\"-")),
               Contains("expected a number as offset"));
    CHECK_THAT(complaint(replaced(Xml{"raw"}({cube()}), " _", " ?")), Contains("expected '_' at the beginning"));
    CHECK_THAT(complaint(replaced(Xml{"raw"}({cube()}), "\"raw\"", "\"hex\"")), Contains("expected encoding raw or base64"));
    CHECK_THAT(complaint(replaced(Xml{"binary"}({cube()}), "AAAA", "AA?A")), Contains("is truncated, or malformed base64"));
    CHECK_THAT(complaint(replaced(Xml{"binary", true}({cube()}), "vtkZLib", "vtkLZ4")),
               Contains("is compressed by 'vtkLZ4DataCompressor', which is not read: only vtkZLibDataCompressor is"));
}

TEST_CASE("base64 may hold white space and padding anywhere", "[input][vtp]") {
    const TempFolder dir;
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
    const TempFolder dir;
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
    CHECK_THAT(read_error(dir.write("a.vtp", damaged)).message, Contains("its compressed block 0 does not expand"));
}

TEST_CASE("VTP that expands enormously is refused before it is unpacked", "[input][vtp]") {
    const TempFolder dir;
    PolyData data = sheet(150);
    for (auto& cell : data.polygons) {
        cell = {0, 1, 2};
    }
    Xml xml{"raw", true, false, true, "Float32", "Int64", 32768};
    const auto path = dir.write("a.vtp", xml({data}));
    ReadOptions options;
    options.memory_limit_bytes = 500'000;
    const Result<MeshFile> mesh = read_mesh(path, options);
    REQUIRE_FALSE(mesh.ok());
    CHECK(mesh.error().code == ErrorCode::out_of_memory);
    CHECK_THAT(mesh.error().message, Contains("expands to more than the 500000 bytes that reading it may take"));
    // A count that the compressed bytes cannot hold is not asked of the limit.
    const std::string few = replaced(Xml{"raw", true}({cube()}), "NumberOfPoints=\"8\"", "NumberOfPoints=\"1000000\"");
    CHECK(read_error(dir.write("b.vtp", few)).code == ErrorCode::malformed_mesh);
    std::string pieces;
    for (int i = 0; i < 5000; ++i) {
        pieces += "<Piece NumberOfPoints=\"0\"/>";
    }
    const auto many = dir.write("c.vtp", replaced(Xml{}({cube()}), "<PolyData>", "<PolyData>" + pieces));
    CHECK(read_one(many).triangle_count == 12);
    CHECK(read_mesh(many, options).error().code == ErrorCode::out_of_memory);
}

TEST_CASE("compressed integers of 64 bits are held in 32, unless they are larger", "[input][vtp]") {
    const TempFolder dir;
    const PolyData data = sheet(200);
    const Xml xml{"raw", true, GENERATE(false, true), true, "Float32", "Int64", 32768};
    const auto path = dir.write("a.vtp", Xml{xml}({data}));
    ReadOptions options;
    options.memory_limit_bytes = 2'300'000;  // 1.9 MB are needed so, and 2.6 otherwise
    const Result<MeshFile> mesh = read_mesh(path, options);
    REQUIRE(mesh.ok());
    CHECK(triangles_of(mesh.value()) == triangles_of(read_one(dir.write("b.vtp", Xml{}({data})))));
    PolyData large = cube();
    large.polygons[5][3] = 0xFFFFFFFF;
    Xml larger{xml};
    larger.integers = "Int64";
    CHECK_THAT(read_error(dir.write("a.vtp", larger({large}))).message,
               Contains("point 4294967295 of Polys does not exist: there are 8"));
}

TEST_CASE("markup in VTP array text is parsed as XML, and refused with its line", "[input][vtp]") {
    const TempFolder dir;
    const std::string whole = Xml{}({cube()});
    const std::size_t numbers = whole.find('>', whole.find("connectivity", whole.find("<Polys"))) + 1;
    const auto with = [&](const std::string& more) {
        std::string file = whole;
        file.insert(file.find('<', numbers), more);
        return file;
    };
    CHECK(read_one(dir.write("a.vtp", with(" \t\r\n "))).triangle_count == 12);
    CHECK_THAT(read_error(dir.write("a.vtp", with("<!-- <DataArray> -->"))).message, Contains("found '<!--'"));
    const std::size_t lines = static_cast<std::size_t>(
        std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.find('<', numbers)), '\n'));
    const std::string line = "line " + std::to_string(lines + 1) + ",";
    for (const char* const more : {"&", "]]>", "&unknown;", "\x01", "\xFF"}) {
        const std::string message = read_error(dir.write("a.vtp", with(more))).message;
        CHECK_THAT(message, Contains("malformed XML") && Contains(line));
    }
    CHECK_THAT(read_error(dir.write("a.vtp", with("+"))).message, Contains("found '+"));
}

}  // namespace lamella::vtk_test
