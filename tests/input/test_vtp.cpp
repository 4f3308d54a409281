#include <string>

#include "vtp_files.hpp"

namespace lamella::vtk_test {

TEST_CASE("VTP gives the same triangles however its arrays are stored", "[input][vtp]") {
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
    CHECK(mesh.text == (format == "ascii"));
    CHECK(mesh.vertex_count == 8);
    CHECK(mesh.warnings.empty());
}

TEST_CASE("VTP takes arrays of every type", "[input][vtp]") {
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
            CHECK(read_one(path).vertex_type == Number::f64);
        }
    }
}

TEST_CASE("all pieces of VTP are read, one after the other", "[input][vtp]") {
    // The second are triangles alone, which are read another way.
    const std::vector<PolyData> pieces = GENERATE(std::vector<PolyData>{cube(3), {}, cube_with_strip(), sheet(90)},
                                                  std::vector<PolyData>{triangle(3), {}, triangle(5)});
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

TEST_CASE("VTP is read in every accepted spelling", "[input][vtp]") {
    const std::string plain = Xml{}({cube()});
    for (const std::string& text :
         {"\xEF\xBB\xBF" + plain, plain.substr(plain.find("<VTKFile")), replaced(plain, "\n", "\r\n"),
          replaced(plain, "<PolyData>", "<!-- <AppendedData> -->\n<PolyData>")}) {
        CHECK(read_triangles(dir.write("a.vtp", text)) == triangles_of(cube()));
    }
}

TEST_CASE("field data of VTP may state the patient frame", "[input][vtp]") {
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary");
    const auto frame = [&](const std::string& name, const std::string& value, bool ended = true) {
        Xml xml{format};
        const std::string bytes = ended ? value + '\0' : value;
        std::string codes;
        for (const char c : bytes) {
            codes += xml.text() ? std::to_string(int{c}) + " " : std::string(1, c);
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

}  // namespace lamella::vtk_test
