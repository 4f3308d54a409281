#include <string>

#include <catch2/catch.hpp>

#include "vtp_files.hpp"

namespace lamella::vtk_test {

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

}  // namespace lamella::vtk_test
