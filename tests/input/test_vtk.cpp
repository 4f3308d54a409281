#include <limits>
#include <string>

#include "vtk_files.hpp"

namespace lamella::vtk_test {

using Catch::Contains;

namespace {

struct Legacy {
    bool text = true;
    int version = 3;
    std::string points = "float";
    std::string integers = "vtktypeint64";  ///< of offsets and connectivity, from version 5 on
    std::string extra{};                    ///< between points and cells

    Encoding encoding() const { return {text, true}; }
    std::string array(const std::string& type, const std::vector<double>& values) const {
        std::string bytes;
        for (const double value : values) {
            bytes += encoding().as(type, value);
        }
        return bytes + "\n";
    }
    std::string header() const {
        return "# vtk DataFile Version " + std::to_string(version) + (version == 5 ? ".1" : ".0") + "\na title\n" +
               (text ? "ASCII" : "BINARY") + "\nDATASET POLYDATA\n";
    }
    std::string cells(const std::string& name, const Cells& cells) const {
        if (cells.empty()) {
            return "";
        }
        std::vector<double> counted;
        std::vector<double> offsets{0};
        std::vector<double> corners;
        for (const auto& cell : cells) {
            counted.push_back(static_cast<double>(cell.size()));
            counted.insert(counted.end(), cell.begin(), cell.end());
            corners.insert(corners.end(), cell.begin(), cell.end());
            offsets.push_back(static_cast<double>(corners.size()));
        }
        if (version < 5) {
            return name + " " + std::to_string(cells.size()) + " " + std::to_string(counted.size()) + "\n" +
                   array("int", counted);
        }
        return name + " " + std::to_string(offsets.size()) + " " + std::to_string(corners.size()) + "\nOFFSETS " + integers +
               "\n" + array(integers, offsets) + "CONNECTIVITY " + integers + "\n" + array(integers, corners);
    }
    std::string operator()(const PolyData& data) const {
        std::vector<double> coordinates;
        for (const auto& point : data.points) {
            coordinates.insert(coordinates.end(), point.begin(), point.end());
        }
        return header() + "POINTS " + std::to_string(data.points.size()) + " " + points + "\n" + array(points, coordinates) +
               extra + cells("POLYGONS", data.polygons) + cells("TRIANGLE_STRIPS", data.strips);
    }
};

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return text;
}

}  // namespace

TEST_CASE("legacy VTK in every form gives the same triangles", "[input][vtk][threads]") {
    const PolyData data = GENERATE(cube(), cube_with_strip(), sheet(200));
    const bool text = GENERATE(false, true);
    for (const int version : {1, 2, 3, 4, 5}) {
        for (const char* integers : {"vtktypeint64", "vtktypeint32", "unsigned_int", "vtkIdType"}) {
            const bool id = std::string(integers) == "vtkIdType";  // 32 bits in the file
            Legacy legacy{text, version, "float", id ? "int" : integers, ""};
            const std::string file = replaced(legacy(data), " int\n", id ? " vtkIdType\n" : " int\n");
            CHECK(read_triangles(dir.write("a.vtk", file)) == triangles_of(data));
            if (version < 5) {
                break;
            }
        }
    }
    const MeshFile mesh = read_one(dir.write("b.vtk", Legacy{text}(data)));
    CHECK(mesh.text == text);
    CHECK(mesh.vertex_count == data.points.size());
    CHECK(mesh.warnings.empty());
    CHECK_FALSE(mesh.states_unit);
}

TEST_CASE("legacy VTK takes points of every type", "[input][vtk]") {
    const PolyData data = cube_with_strip();
    const bool text = GENERATE(false, true);
    for (const char* type : {"float", "double", "char", "unsigned_char", "short", "unsigned_short", "int", "unsigned_int",
                             "long", "unsigned_long", "vtktypeint64"}) {
        CHECK(read_triangles(dir.write("a.vtk", Legacy{text, 4, type}(data))) == triangles_of(data));
    }
    PolyData fine = cube();
    fine.points[0][0] = 1.0 / 3;  // no float
    const MeshFile mesh = read_one(dir.write("b.vtk", Legacy{false, 4, "double"}(fine)));
    CHECK(mesh.vertex_type == Number::f64);
    CHECK(corner_of(mesh.view(), 0, 0)[0] == 1.0 / 3);
}

TEST_CASE("legacy VTK is read in every accepted spelling", "[input][vtk]") {
    const PolyData data = cube_with_strip();
    const std::string plain = Legacy{}(data);
    const std::string head = Legacy{}.header();
    const std::string text =
        GENERATE_COPY(as<std::string>(), replaced(plain, "\n", "\r\n"), replaced(plain, "\n", "\r"),
                      head + replaced(plain.substr(head.size()), " ", "\t "), upper(plain), lower(plain),
                      "\xEF\xBB\xBF" + plain, replaced(plain, "a title", ""),
                      replaced(plain, "a title", std::string(5000, 'x')), plain.substr(0, plain.size() - 2),
                      upper(Legacy{true, 5}(data)), replaced(Legacy{false, 3}(data), "float\n", "float \r\n"));
    INFO(text);
    CHECK(read_triangles(dir.write("a.vtk", text)) == triangles_of(data));
}

TEST_CASE("data other than the surface are skipped in legacy VTK", "[input][vtk]") {
    const PolyData data = cube();
    const bool text = GENERATE(false, true);
    const int version = GENERATE(3, 5);
    Legacy legacy{text, version};
    const std::string strings = text ? "one%20two\n\nPOLYGONS%201\n" : std::string("\xC3") + "1\n2\xC0\x80\x03" + "abc\n";
    const std::string bits = text ? "0 1 0 1 0 1 0 1 1\n" : "ab\n";
    legacy.extra = "METADATA\nCOMPONENT_NAMES\nx\ny\nINFORMATION 1\nNAME POLYGONS LOCATION y\nDATA 1\n\n" +
                   legacy.cells("VERTICES", {{0}, {1}}) + legacy.cells("LINES", {{0, 1, 2}}) + "FIELD FieldData 4\n" +
                   "notes 1 3 string\n" + strings + "flags 3 3 bit\n" + bits + "METADATA\nINFORMATION 0\n\n" +
                   "time 1 2 double\n" + legacy.array("double", {1, 2}) + "none 0 0 int\n\n";
    const std::string file = legacy(data);
    CHECK(read_triangles(dir.write("a.vtk", file)) == triangles_of(data));
    for (const char* rest :
         {"POINT_DATA 8\nSCALARS a float\nLOOKUP_TABLE default\nwhatever", "CELL_DATA 6\nPOLYGONS 1 1", "point_data 8"}) {
        CHECK(read_triangles(dir.write("a.vtk", file + rest)) == triangles_of(data));
    }
}

TEST_CASE("a FIELD of legacy VTK may state the patient frame", "[input][vtk]") {
    const bool text = GENERATE(false, true);
    const auto read = [&](const std::string& head, const std::vector<std::string>& values,
                          const std::string& title = "a title") {
        Legacy legacy{text, 5};
        legacy.extra = "FIELD FieldData 2\n" + head + " string\n";
        for (const std::string& value : values) {
            legacy.extra += text ? value + "\n" : static_cast<char>(0xC0 + value.size()) + value;
        }
        legacy.extra += "\ntime 1 1 double\n" + legacy.array("double", {1});
        return read_one(dir.write("a.vtk", replaced(legacy(cube()), "a title", title)));
    };
    CHECK(read("SPACE 1 1", {"LPS"}).patient_frame == PatientFrame::lps);
    CHECK(read("SPACE 1 1", {"RAS"}).patient_frame == PatientFrame::ras);
    CHECK(read("SPACE 1 1", {"RAS"}, "SPACE=RAS").patient_frame == PatientFrame::ras);
    CHECK(read("SPACE 1 1", {"RASP"}).patient_frame == PatientFrame::unstated);
    CHECK(read("SPACE 1 2", {"LPS", "RAS"}).patient_frame == PatientFrame::unstated);
    CHECK(read("OTHER 1 1", {"LPS"}).patient_frame == PatientFrame::unstated);
    CHECK(read("SPACE 1 1", {"RAS"}, "3D Slicer output. SPACE=LPS").patient_frame == PatientFrame::unstated);
    CHECK(warnings_of(dir / "a.vtk") == Texts{"states the patient frame 'LPS' and then 'RAS', so that neither is taken"});
}

TEST_CASE("cells of VTK without an area are ignored with a warning", "[input][vtk]") {
    PolyData data = cube();
    data.polygons.insert(data.polygons.begin() + 2, {{0, 1}, {}, {3}});
    for (const bool text : {false, true}) {
        for (const int version : {3, 5}) {
            const auto path = dir.write("a.vtk", Legacy{text, version}(data));
            CHECK(read_triangles(path) == triangles_of(cube()));
            CHECK(warnings_of(path) ==
                  Texts{"ignored 3 cells of POLYGONS with fewer than three corners, the first being cell 2"});
        }
    }
}

TEST_CASE("legacy VTK without triangles is an empty mesh", "[input][vtk]") {
    PolyData data = cube();
    data.polygons.clear();
    for (const std::string& file :
         {Legacy{}(data), Legacy{true, 5}(data) + "POLYGONS 0 0\n", Legacy{false}(data) + "POLYGONS 0 0\n", Legacy{}({})}) {
        CHECK(read_error(dir.write("a.vtk", file)).code == ErrorCode::empty_mesh);
    }
}

TEST_CASE("legacy VTK cut off anywhere is refused", "[input][vtk]") {
    const bool text = GENERATE(false, true);
    const int version = GENERATE(3, 5);
    Legacy legacy{text, version};
    legacy.extra = std::string("FIELD FieldData 2\nnote 1 1 string\n") + (text ? "" : "\xC3") + "abc\nt 1 1 double\n" +
                   legacy.array("double", {7});
    PolyData data = cube();
    data.polygons.push_back({0, 1, 7});
    const std::string whole = legacy(data);
    const std::size_t complete = whole.size() - (text ? 2 : 1);  // behind the last number
    CHECK(read_triangles(dir.write("a.vtk", whole.substr(0, complete))) == triangles_of(data));
    // Where a section ends, nothing is wrong but what is missing.
    refuses_cuts("a.vtk", whole, 22, complete, true);
}

TEST_CASE("malformed legacy VTK is refused with the place", "[input][vtk]") {
    const std::string plain = Legacy{}(cube());
    const std::vector<Malformed> cases = {
        {"POLYDATA", "UNSTRUCTURED_GRID",
         "line 4, byte 49: expected 'POLYDATA', the only kind of DATASET that is read, found "
         "'UNSTRUCTURED_GRID'"},
        {"Version 3.0", "Version 6.0", "expected a version from 1.0 to 5.x, found '6.0'"},
        {"Version 3.0", "Version -1", "found '-1'"},
        {"ASCII", "XML", "line 3, ", "expected 'ASCII' or 'BINARY', found 'XML'"},
        {"DATASET", "SET", "expected 'DATASET'"},
        {"POINTS 8", "POINTS -8", "line 5, ", "expected the number of POINTS, found '-8'"},
        {"POINTS 8", "POINTS 9", "malformed coordinate 'POLYGONS'"},
        {"POINTS 8", "POINTS 7", "expected POINTS, POLYGONS, TRIANGLE_STRIPS or another section"},
        {"POINTS 8", "POINTS 5000000000", "expected fewer than 2^32 POINTS"},
        {"POINTS 8", "POINTS 4000000000", "expected 12000000000 numbers of POINTS, found "},
        {"POINTS 8", "POINTS 99999999999999999999", "expected the number of POINTS"},
        {"float", "half", "expected a type of numbers, found 'half'"},
        {"10.000000 10.000000 10.000000 ", "10 ten 10 ", "malformed coordinate 'ten'"},
        {"10.000000 10.000000 10.000000 ", "10 1e39 10 ", "is not a finite number: '1e39'"},
        {"POLYGONS 6 30", "POLYGONS 6 31", "expected 31 numbers of POLYGONS, found 30"},
        {"POLYGONS 6 30", "POLYGONS 5 30", "take 25 numbers, not the 30 counted"},
        {"POLYGONS 6 30", "POLYGONS 7 30", "cell 6 of POLYGONS does not lie within the 30 numbers"},
        {"POLYGONS 6 30", "POLYGONS 6 18446744073709551615", "found 30"},
        {"4 0 2 3 1", "4 0 2 8 1", "line 8, ", "point 8 of POLYGONS does not exist: there are 8"},
        {"4 0 2 3 1", "4 0 -1 3 1", "expected an integer from 0 to 4294967295, found '-1'"},
        {"4 0 2 3 1", "4294967295 0 2 3 1", "cell 0 of POLYGONS does not lie within"},
        {"POLYGONS 6", "POLYGON 6", "found 'POLYGON'"},
    };
    refuses_each("a.vtk", plain, cases);
    for (const auto& [file, says] : {
             std::pair(plain + Legacy{}.cells("POLYGONS", {{0, 1, 2}}), "expected one section POLYGONS"),
             {plain + "POINTS 1 float\n1 2 3\n", "expected one section POINTS"},
             {Legacy{}.header() + Legacy{}.cells("POLYGONS", {{0, 1, 2}}), "expected POINTS, found the end"},
             {plain + "FIELD f 1\na 4294967296 4294967295 int\n", "numbers of FIELD a"},
             {plain + "FIELD f 1\na 4294967296 4294967297 int\n", "possible number of values"},
             {plain + "FIELD f 1\na 1 18446744073709551615 string\nx", "within the strings of FIELD a"},
             {plain + "FIELD f 1\na 1 1 variant\nx", "found 'variant'"},
         }) {
        refuses(dir.write("a.vtk", file), says);
    }
}

TEST_CASE("offsets of legacy VTK must ascend and end with the connectivity", "[input][vtk]") {
    const std::string plain = Legacy{true, 5}(cube());
    refuses_each("a.vtk", plain,
                 {
                     {"0 4 8 ", "1 4 8 ", "the offsets of POLYGONS do not begin with 0"},
                     {"0 4 8 ", "0 9 8 ", "line 9, ", "cell 1 of POLYGONS ends at 8, which is not from 9 to 24"},
                     {" 20 24 ", " 20 23 ", "have 23 corners, not the 24 of their connectivity"},
                     {" 20 24 ", " 20 25 ", "ends at 25, which is not from 20 to 24"},
                     {" 20 24 ", " 20 18446744073709551615 ", "ends at -1"},
                     {"CONNECTIVITY", "CONNECTED", "expected 'CONNECTIVITY' of POLYGONS, found 'CONNECTED'"},
                     {"OFFSETS vtktypeint64", "OFFSETS float", "expected a type of integers, found 'float'"},
                     {"POLYGONS 7 24", "POLYGONS 6 24", "expected 'CONNECTIVITY' of POLYGONS, found '24'"},
                 });
}

TEST_CASE("malformed binary legacy VTK is refused with the byte", "[input][vtk]") {
    const int version = GENERATE(3, 5);
    const PolyData data = sheet(120);
    const std::string plain = Legacy{false, version}(data);
    const auto last = read_error(dir.write("a.vtk", replaced(plain, "POINTS 14641", "POINTS 14640")));
    CHECK_THAT(last.message, Contains(": byte " + std::to_string(last.byte_offset) + ": expected POINTS, POLYGONS"));
    refuses(dir.write("a.vtk", replaced(plain, "POINTS 14641", "POINTS 4294967295")),
            "is truncated: expected 12884901885 numbers of POINTS at 4 bytes");
    refuses(dir.write("a.vtk", replaced(plain, "float\n", "float\r")),
            "expected the end of the line before the bytes of POINTS");

    PolyData bad = data;
    for (const std::size_t cell : {std::size_t{5}, bad.polygons.size() / 3, bad.polygons.size() - 2}) {
        bad.polygons[cell][2] = 14641;
    }
    const Error error =
        refuses(dir.write("a.vtk", Legacy{false, version}(bad)), "point 14641 of POLYGONS does not exist: there are 14641");
    const std::size_t cells = plain.find(version == 5 ? "CONNECTIVITY vtktypeint64\n" : "POLYGONS ");
    const std::size_t begin = plain.find('\n', cells) + 1;
    CHECK(error.byte_offset == static_cast<std::int64_t>(begin + (version == 5 ? 8 * (5 * 3 + 2) : 4 * (5 * 4 + 3))));
    bad = data;
    bad.polygons.back()[1] = 0x80000000;
    refuses(dir.write("a.vtk", Legacy{false, version, "float", "int"}(bad)), "point -2147483648 of POLYGONS does not exist");
}

TEST_CASE("a polygon of VTK with a corner that is not finite is refused", "[input][vtk]") {
    PolyData data = cube();
    data.points[3][1] = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
    const auto path = dir.write("a.vtk", Legacy{false, 5}(data));
    CHECK(refuses(path, "point 3 of POLYGONS has a coordinate that is not finite").code == ErrorCode::malformed_mesh);
}

TEST_CASE("memory for legacy VTK is counted before it is allocated", "[input][vtk]") {
    PolyData data = sheet(100);
    data.strips.emplace_back();
    for (std::uint32_t i = 0; i < 20'000; ++i) {
        data.strips[0].push_back(i % 10);
    }
    const auto path = dir.write("a.vtk", Legacy{GENERATE(false, true)}(data));
    CHECK_THAT(message_beyond(200'000, path), Contains("expands to more than the 200000 bytes that reading it may take"));
    CHECK(read_mesh(path, {.memory_limit_bytes = 2'000'000}).ok());
}

}  // namespace lamella::vtk_test
